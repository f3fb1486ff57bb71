// Do the turns between poses bear their time stamps out?
#pragma once

#include <cstddef>
#include <span>

#include "motion/pose_history.hpp"

namespace polhode {

/// Stamps of arrival come in bursts, while the body turns alike from frame to frame.
struct StampDoubt {
  bool contradicted = false;  ///< no rate can be read from these times
  double shortest_s = 0.0;    ///< interval among the poses that were looked at
  double longest_s = 0.0;
};

/// Of the last poses of `history`, 16 at most: some intervals are far longer than most, and over
/// each of them the body turned as it did in the interval beside it. A body that had the time for
/// many turns comes out so by chance in one such interval out of a hundred.
/// @param history  time strictly increasing, in axes that do not turn.
StampDoubt doubt_of_stamps(std::span<const PoseSample> history);

/// Of the poses about `history[index]`, on both sides.
StampDoubt doubt_of_stamps_about(std::span<const PoseSample> history, std::size_t index);

}  // namespace polhode
