// Which faults of a file are the settings', and which the machine's.
#pragma once

#include <filesystem>
#include <string>

namespace polhode::platform {

/// For a file or socket that cannot be opened, made or written at a start.
/// @param what   for people, the file's name first.
/// @param error  errno.
/// @throws RunFailure where disk or machine is at fault, which may pass: no space, a read error, a
/// file system that has become read-only, too many files, no memory, a port that another process
/// has. Else UnusableInput: starting again changes nothing.
[[noreturn]] void fail_at_start(const std::string& what, int error);

/// The same for an open() that failed. The message names another user that owns the file: a file
/// left by root blocks a service that runs as another user.
[[noreturn]] void fail_to_open(const std::filesystem::path& file,
                               const std::string& what,
                               int error);

}  // namespace polhode::platform
