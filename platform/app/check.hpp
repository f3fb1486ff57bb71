// polhode check: validates a configuration and prints the effective table; starts nothing.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace polhode::platform {

struct CheckArguments {
  std::filesystem::path config;
  std::filesystem::path sequence;  ///< empty: the configuration alone
  std::vector<std::string> settings;
  bool memory = false;    ///< print the whole memory plan as well; one that does not fit is refused
  bool defaults = false;  ///< print a documented file of defaults instead
  bool bus_parameters = false;  ///< print the part of the bus's field table instead
};

/// @throws UnusableInput naming the first problem.
void check_configuration(const CheckArguments& arguments);

}  // namespace polhode::platform
