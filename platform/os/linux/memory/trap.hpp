// For tests of the seal: the kernel itself tells when a program that should not asks for memory, a
// thread or a file.
#pragma once

namespace polhode::platform {

inline constexpr int kTrapped = 5;  ///< exit code

/// From here on mmap, mremap, munmap, mprotect, madvise, brk, clone, fork and, where `files` says
/// so, open end the process with kTrapped and one line that names the call; for all threads, and
/// for good.
/// @return false when the kernel does not allow such a filter.
bool set_memory_trap(bool files);

}  // namespace polhode::platform
