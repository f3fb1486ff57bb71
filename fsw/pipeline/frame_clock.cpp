#include "pipeline/frame_clock.hpp"

#include "base/sound.hpp"

namespace polhode {
namespace {

/// Later, and by no more than a run lasts. What is later than that is a wrong time, too: taken for
/// right it would make all that has a time look damaged.
bool follows(std::int64_t time_ns, std::int64_t last_ns) {
  return time_ns > last_ns && sound::is_past(last_ns, time_ns);
}

}  // namespace

Admission admit(std::int64_t timestamp_ns, FrameClock* clock, std::uint32_t* missing) {
  *missing = 0;
  const bool rises = !clock->time_known || follows(timestamp_ns, clock->timestamp_ns);
  if (!rises && !outvotes(timestamp_ns, &clock->doubt)) {
    return Admission::kNotLater;
  }
  if (!rises) {
    clock->arrivals = {};
    clock->timestamp_ns = timestamp_ns;  // whatever becomes of its picture
  }
  clock->doubt = {};
  *missing = static_cast<std::uint32_t>(missing_frames(timestamp_ns, &clock->arrivals));
  return rises ? Admission::kLater : Admission::kTimeWasWrong;
}

}  // namespace polhode
