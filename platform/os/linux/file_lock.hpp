// One process at a time has a file, or a folder.
#pragma once

#include <string>

namespace polhode::platform {

/// Takes the lock on an open file or folder, which goes with its descriptor, however the process
/// ends. Never waits.
/// @return empty; or that another process has it, with that one's pid where the kernel tells.
std::string lock_file(int descriptor);

}  // namespace polhode::platform
