// One process at a time has a file, or a folder.
#pragma once

#include <filesystem>
#include <string>

#include "os/linux/descriptor.hpp"

namespace polhode::platform {

/// Takes the lock on an open file or folder, which goes with its descriptor, however the process
/// ends. Never waits.
/// @param what  names it in what is thrown.
/// @throws RunFailure: another process has it, with its pid where the kernel gives it, or the
/// system cannot lock it. Both may pass: the other process ends one day.
void lock_file(int descriptor, const std::string& what);

/// Locks a file that is replaced by others of its name, by one beside it, NAME.lock, which stays.
/// @throws as lock_file() and fail_at_start().
Descriptor lock_beside(const std::filesystem::path& file);

}  // namespace polhode::platform
