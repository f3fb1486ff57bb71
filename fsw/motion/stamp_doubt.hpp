// Consistency of time stamps with the rotations between poses.
#pragma once

#include <cstddef>
#include <span>

#include "motion/pose_history.hpp"

namespace polhode {

/// Stamps taken at arrival come in bursts, while the rotation from frame to frame stays alike.
struct StampDoubt {
  bool contradicted = false;  ///< no rate can be computed from these times
  double shortest_s = 0.0;    ///< interval among the checked poses
  double longest_s = 0.0;
};

/// Checks the last poses of `history`, 16 at most. Contradicted if some intervals are far longer
/// than most, and over each the body rotated as in the interval beside it. A body with time for
/// many turns shows this by chance in one such interval out of a hundred.
/// @param history  time strictly increasing, in axes that do not turn.
StampDoubt doubt_of_stamps(std::span<const PoseSample> history);

/// The same for the poses about `history[index]`, on both sides.
StampDoubt doubt_of_stamps_about(std::span<const PoseSample> history, std::size_t index);

}  // namespace polhode
