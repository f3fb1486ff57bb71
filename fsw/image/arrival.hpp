// Frames that never came, told by the gaps that they leave in time.
#pragma once

#include <cstdint>

#include "base/fixed_vector.hpp"

namespace polhode {

struct ArrivalHistory {
  static constexpr std::size_t kIntervals = 15;
  bool any = false;
  std::int64_t last_ns = 0;
  FixedVector<std::int64_t, kIntervals> intervals_ns;  ///< the last ones, oldest first
};

/// Takes note of a frame, whatever became of its picture.
/// @param timestamp_ns  one that is not later than the last one's tells nothing.
/// @return frames missing before it: the interval is that many periods too long, to a quarter of a
/// period, the period being the median of the last intervals. 0 until three intervals are known.
int missing_frames(std::int64_t timestamp_ns, ArrivalHistory* history);

}  // namespace polhode
