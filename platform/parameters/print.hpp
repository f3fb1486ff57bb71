// Prints the parameters: the effective table, and the documented file of defaults.
#pragma once

#include <string>

#include "parameters/load.hpp"

namespace polhode::platform {

/// One line a parameter: key, value, allowed range, unit, and where the value comes from.
std::string effective_table(const Configuration& configuration);

/// A complete configuration file with every key, its default, range, unit and meaning.
/// config/default.toml is this text.
std::string documented_defaults();

}  // namespace polhode::platform
