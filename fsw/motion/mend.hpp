// Repair of the motion's state after bit flips in memory.
#pragma once

#include <cstdint>

#include "base/repair.hpp"
#include "motion/motion_estimate.hpp"

namespace polhode {

/// Leaves a valid state unchanged. Otherwise drops invalid poses and an invalid model; the next fit
/// gives a new one. Drops all poses if the state is still invalid.
Repair repair(std::int64_t now_ns, MotionEstimate* motion);

}  // namespace polhode
