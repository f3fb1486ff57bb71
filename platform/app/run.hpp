// polhode run: the live program, from a camera to the bus, until a request to stop.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace polhode::platform {

struct RunArguments {
  std::filesystem::path config;
  bool memory_trap = false;  ///< as in ReplayArguments
  std::vector<std::string> settings;
};

/// @throws UnusableInput before anything started; RunFailure afterwards.
void run_command(const RunArguments& arguments);

}  // namespace polhode::platform
