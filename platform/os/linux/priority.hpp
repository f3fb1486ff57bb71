// Priority and core of the thread that steps frames.
#pragma once

#include <string>

namespace polhode::platform {

/// Gives the calling thread a real-time priority (SCHED_FIFO). Threads made before keep theirs.
/// @param priority 1 .. 99
/// @return why it could not be done; empty when it was.
std::string take_priority(int priority);

/// Binds the calling thread to one core. Threads made before are not.
/// @param core 0 ..
/// @return why it could not be done; empty when it was.
std::string take_core(int core);

}  // namespace polhode::platform
