// A remembered motion whose memory was hit by bit flips goes on with what is sound of it.
#pragma once

#include <cstdint>

#include "base/repair.hpp"
#include "motion/motion_estimate.hpp"

namespace polhode {

/// Nothing happens to a sound one. Of another one, poses that are not sound are dropped, and a
/// model that is not; the next fit makes a new one. Where that does not do, all poses go.
Repair repair(std::int64_t now_ns, MotionEstimate* motion);

}  // namespace polhode
