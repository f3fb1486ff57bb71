// Capacities of the bus, with their reasons; those of the estimator are in config/limits.hpp.
#pragma once

#include <cstddef>

#include "config/limits.hpp"

namespace polhode::limits {

// All packets of one step: one of each kind (3.4 kB), all events (4.4 kB) and three more parts of a
// cloud (4.1 kB).
inline constexpr std::size_t kStepOctets = 12288;

// Events of one step: two for each command (a refused table tells its entry, too) and eight of the
// component's own.
inline constexpr std::size_t kStepEvents = 24;

// Commands executed in one step; a ground pass sends a few a second.
inline constexpr std::size_t kStepCommands = 8;

}  // namespace polhode::limits
