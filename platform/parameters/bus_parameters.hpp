// The parameters that commands may change, for the field table of the bus.
#pragma once

#include <string>

namespace polhode::platform {

/// One table a parameter: key, type on the wire, range or words, default, unit, meaning.
/// config/bus/parameters.toml is this text.
std::string bus_parameters();

}  // namespace polhode::platform
