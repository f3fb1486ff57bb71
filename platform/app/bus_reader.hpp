// An open end of the bus, for the commands that read it.
#pragma once

#include <memory>
#include <string>

struct polhode_bus;

namespace polhode::platform {

struct CloseBus {
  void operator()(polhode_bus* bus) const;
};
using BusReader = std::unique_ptr<polhode_bus, CloseBus>;

/// @throws UnusableInput: the address cannot be opened.
BusReader open_bus_reader(const std::string& address);

}  // namespace polhode::platform
