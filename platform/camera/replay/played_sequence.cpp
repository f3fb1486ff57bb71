#include "camera/replay/played_sequence.hpp"

#include <algorithm>

#include "base/assert.hpp"
#include "camera/v4l2/device_calls.hpp"

namespace polhode::platform {

std::size_t played_frames(const Sequence& sequence, int passes) {
  return (sequence.frames.size() - 1) * static_cast<std::size_t>(passes) + 1;
}

PlayedFrame played_frame(const Sequence& sequence, std::size_t position) {
  POLHODE_ASSERT(!sequence.frames.empty(), position);
  const std::size_t last = sequence.frames.size() - 1;
  if (last == 0) {
    return {.index = 0, .timestamp_ns = sequence.frames[0].timestamp_ns};
  }
  const std::int64_t begin_ns = sequence.frames.front().timestamp_ns;
  const std::int64_t end_ns = sequence.frames.back().timestamp_ns;
  const std::size_t pass = position / last;
  const std::size_t along = position % last;
  const bool forth = pass % 2 == 0;
  const std::size_t index = forth ? along : last - along;
  const std::int64_t here_ns = sequence.frames[index].timestamp_ns;
  const std::int64_t into_pass_ns = forth ? here_ns - begin_ns : end_ns - here_ns;
  return {.index = index,
          .timestamp_ns =
              begin_ns + static_cast<std::int64_t>(pass) * (end_ns - begin_ns) + into_pass_ns};
}

PlayedSequence::PlayedSequence(const Sequence& sequence, const PlayOptions& options)
    : sequence_(sequence),
      options_(options),
      files_(sequence),
      frames_(played_frames(sequence, options.passes)) {
  counters_.opened = 1;
}

std::int64_t PlayedSequence::due_ns(std::size_t position) const {
  const std::int64_t since_first_ns =
      played_frame(sequence_, position).timestamp_ns - sequence_.frames.front().timestamp_ns;
  return options_.start_ns +
         static_cast<std::int64_t>(static_cast<double>(since_first_ns) / options_.speed);
}

void PlayedSequence::pass_over_late(std::int64_t now_ns) {
  const auto waiting = static_cast<std::size_t>(1 + options_.backlog_frames_max);
  while (position_ + waiting < frames_ && due_ns(position_ + waiting) <= now_ns) {
    ++position_;
    has_read_ = false;
    ++counters_.frames_late;
  }
}

/// Done before the frame is due: a camera's is in memory when it is there, so decoding is no part
/// of the time from a frame to its packet.
void PlayedSequence::read_ahead() {
  if (!has_read_) {
    files_.seek(played_frame(sequence_, position_).index);
    (void)files_.next(ahead_);
    has_read_ = true;
  }
}

Arrival PlayedSequence::next(int timeout_ms, Frame* frame) {
  if (position_ >= frames_) {
    return Arrival::kEnded;
  }
  if (options_.speed > 0.0) {
    DeviceCalls& machine = linux_device_calls();
    pass_over_late(machine.now_ns());
    read_ahead();
    const std::int64_t wait_ms = (due_ns(position_) - machine.now_ns() + 999'999) / 1'000'000;
    if (wait_ms > 0) {
      machine.sleep_ms(static_cast<int>(std::min<std::int64_t>(wait_ms, timeout_ms)));
      if (machine.now_ns() < due_ns(position_)) {
        ++counters_.timeouts;
        return Arrival::kNothing;
      }
    }
  }
  available_ns_ = options_.speed > 0.0 ? due_ns(position_) : linux_device_calls().now_ns();
  read_ahead();
  *frame = ahead_;
  frame->timestamp_ns = played_frame(sequence_, position_++).timestamp_ns;
  has_read_ = false;
  ++counters_.frames;
  counters_.frames_damaged += frame->readable ? 0 : 1;
  return Arrival::kFrame;
}

}  // namespace polhode::platform
