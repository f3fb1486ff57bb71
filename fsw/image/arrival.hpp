// Counts missing frames, by the gaps in time.
#pragma once

#include <cstdint>

#include "base/fixed_vector.hpp"

namespace polhode {

struct ArrivalHistory {
  // Chosen: their median is right with up to seven gaps. Larger follows a new frame rate later.
  static constexpr std::size_t kIntervals = 15;
  bool any = false;
  std::int64_t last_ns = 0;
  FixedVector<std::int64_t, kIntervals> intervals_ns;  ///< the last ones, oldest first
};

/// Records a frame's time, whatever its verdict.
/// @param timestamp_ns  ignored when it is not later than the last one's.
/// @return frames missing before it, by the length of the interval in periods, if that is a whole
/// number to a quarter. The period is the median of the last intervals. 0 until three intervals are
/// known.
int missing_frames(std::int64_t timestamp_ns, ArrivalHistory* history);

}  // namespace polhode
