#include "pipeline/frame_clock.hpp"

#include "base/validity.hpp"

namespace polhode {

Admission admit(std::int64_t timestamp_ns, FrameClock* clock, std::uint32_t* missing) {
  *missing = 0;
  // Later, and by no more than a run lasts. A later time is wrong, too: if accepted it would make
  // all earlier times look damaged.
  const bool rises = !clock->time_known || (timestamp_ns > clock->timestamp_ns &&
                                            validity::is_past(clock->timestamp_ns, timestamp_ns));
  if (!validity::is_time(timestamp_ns) || (!rises && !outvotes(timestamp_ns, &clock->doubt))) {
    return Admission::kNotLater;
  }
  if (!rises) {
    clock->arrivals = {};
    clock->timestamp_ns = timestamp_ns;  // also where its image is not used
  }
  clock->doubt = {};
  *missing = static_cast<std::uint32_t>(missing_frames(timestamp_ns, &clock->arrivals));
  return rises ? Admission::kLater : Admission::kTimeWasWrong;
}

}  // namespace polhode
