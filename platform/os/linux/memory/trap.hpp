// For tests of the seal: the kernel ends a program that requests memory, a thread or a file when it
// should not.
#pragma once

namespace polhode::platform {

inline constexpr int kTrapped = 5;  ///< exit code

/// From here on mmap, mremap, munmap, mprotect, madvise, brk, clone, fork and, with `files`, open
/// end the process with kTrapped and one line that names the call; for all threads, and for good.
/// @return false when the kernel does not allow such a filter.
bool set_memory_trap(bool files);

}  // namespace polhode::platform
