#include "app/bus_reader.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <system_error>

#include "errors.hpp"
#include "os/linux/file_faults.hpp"
#include "transport/client/c/polhode_bus.h"

namespace polhode::platform {

void CloseBus::operator()(polhode_bus* bus) const {
  polhode_bus_close(bus);
  delete bus;
}

BusReader open_bus_reader(const std::string& address) {
  BusReader bus(new polhode_bus{});
  const int failed = polhode_bus_open(bus.get(), address.c_str());
  if (failed == -EPERM && address.starts_with("shm:")) {
    throw UnusableInput(fmt::format(
        "{}: belongs to another user, or is open to others: only a ring of one's own is read",
        address));
  }
  if (failed != 0) {
    fail_at_start(address + ": cannot be opened", -failed);
  }
  return bus;
}

}  // namespace polhode::platform
