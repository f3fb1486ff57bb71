// Capacities of the bus, with their reasons; those of the estimator are in config/limits.hpp.
#pragma once

#include <cstddef>
#include <cstdint>

#include "config/limits.hpp"

namespace polhode::limits {

// Commands executed in one step. Chosen: a ground pass sends a few a second.
inline constexpr std::size_t kStepCommands = 8;

// Commands that are recognised as repeats. Chosen: one step's and half as many before.
inline constexpr std::size_t kCommandsRemembered = 12;

// Seconds after the last command in which repeats are recognised, by the time of frames. Chosen:
// many times the wait for an answer. A ground station takes longer to restart and count from 1.
inline constexpr std::uint32_t kRepeat_s = 60;

// Events of one step: two for each command (a refused table entry has one of its own) and eight of
// the component's own.
inline constexpr std::size_t kStepEvents = 2 * kStepCommands + 8;

// Packets of one step: one of each kind (3.6 kB), all events (4.4 kB), three more packets of a
// cloud (4.1 kB) and an answer to each command (1.2 kB), 13.3 kB in all
// (tests/bus/fields_test.cpp); rounded up to 13.5 KiB.
inline constexpr std::size_t kStepOctets = 13824;

}  // namespace polhode::limits
