// Which frames may be looked at, by their time.
#pragma once

#include <cstdint>

#include "base/earlier_times.hpp"
#include "image/arrival.hpp"

namespace polhode {

/// The state of this room.
struct FrameClock {
  std::uint32_t frame = 0;  ///< index of this one; no command resets it
  std::uint32_t next_frame = 0;
  std::int64_t timestamp_ns = 0;  ///< of the last frame whose picture could be looked at
  bool time_known = false;
  EarlierTimes doubt;
  ArrivalHistory arrivals;
};

enum class Admission : std::uint8_t {
  kLater,         ///< than the last one
  kNotLater,      ///< or later than a run lasts, or beyond the ends of time: it is passed by
  kTimeWasWrong,  ///< the time before it was: nothing that has a time can stay
};

/// May a frame with this time be looked at? Counts it where it may.
/// @param missing  frames that never came before it, by the intervals so far.
Admission admit(std::int64_t timestamp_ns, FrameClock* clock, std::uint32_t* missing);

}  // namespace polhode
