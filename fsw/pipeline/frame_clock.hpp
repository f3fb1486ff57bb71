// Admits frames by their time.
#pragma once

#include <cstdint>

#include "base/earlier_times.hpp"
#include "image/arrival.hpp"

namespace polhode {

/// The state of this room.
struct FrameClock {
  std::uint32_t frame = 0;  ///< index of this one; no command resets it
  std::uint32_t next_frame = 0;
  std::int64_t timestamp_ns = 0;  ///< of the last frame whose image was used
  bool time_known = false;
  EarlierTimes doubt;
  ArrivalHistory arrivals;
};

enum class Admission : std::uint8_t {
  kLater,         ///< than the last one
  kNotLater,      ///< or later than a run lasts, or out of the range of times: skipped
  kTimeWasWrong,  ///< the time before it: everything with a time is reset
};

/// May a frame with this time be used? Records its arrival where it may.
/// @param missing  frames missing before it, by the intervals so far.
Admission admit(std::int64_t timestamp_ns, FrameClock* clock, std::uint32_t* missing);

}  // namespace polhode
