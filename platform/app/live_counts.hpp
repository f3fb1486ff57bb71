// Counters and measurements of a live run, in memory that does not grow.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "os/linux/clock.hpp"
#include "os/linux/deadline.hpp"

namespace polhode::platform {

/// Failed writes to the disk since the start.
struct WriteFailures {
  std::uint64_t packets = 0;  ///< steps whose packets are not, or not whole, in bus.ccsds
  std::uint64_t checkpoints = 0;
  std::uint64_t records = 0;   ///< of the recording
  std::uint64_t streamed = 0;  ///< packets of file: transports
  bool operator==(const WriteFailures&) const = default;
};

/// Durations in classes of 1/16 of an octave: a percentile is known to 5 %.
class DurationHistogram {
 public:
  void add(std::int64_t duration_ns) {
    const auto duration_us = static_cast<std::uint64_t>(duration_ns > 0 ? duration_ns / 1000 : 0);
    ++classes_[class_of(duration_us)];
    ++count_;
    sum_us_ += duration_us;
    max_us_ = duration_us > max_us_ ? duration_us : max_us_;
  }
  /// Upper end of the class that holds this fraction; 0 without samples.
  [[nodiscard]] std::uint64_t percentile_us(double fraction) const {
    std::uint64_t below = 0;
    for (std::size_t i = 0; i < classes_.size(); ++i) {
      below += classes_[i];
      if (below > 0 && static_cast<double>(below) >= fraction * static_cast<double>(count_)) {
        return upper_end_us(i) < max_us_ ? upper_end_us(i) : max_us_;
      }
    }
    return max_us_;
  }
  [[nodiscard]] std::uint64_t max_us() const { return max_us_; }
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double mean_us() const {
    return count_ == 0 ? 0.0 : static_cast<double>(sum_us_) / static_cast<double>(count_);
  }

 private:
  static constexpr std::size_t kPerOctave = 16;
  static constexpr std::size_t kOctaves = 40;  // 12 days

  static std::size_t class_of(std::uint64_t duration_us) {
    if (duration_us < kPerOctave) {
      return duration_us;
    }
    const auto octave = static_cast<std::size_t>(std::bit_width(duration_us)) - 5;
    const std::size_t found = kPerOctave * octave + (duration_us >> octave);
    return found < kPerOctave * kOctaves ? found : kPerOctave * kOctaves - 1;
  }
  static std::uint64_t upper_end_us(std::size_t index) {
    if (index < kPerOctave) {
      return index;
    }
    const std::size_t octave = index / kPerOctave - 1;
    const std::uint64_t lower = (index - kPerOctave * octave);
    return ((lower + 1) << octave) - 1;
  }

  std::array<std::uint32_t, kPerOctave * kOctaves> classes_{};
  std::uint64_t count_ = 0;
  std::uint64_t sum_us_ = 0;
  std::uint64_t max_us_ = 0;
};

struct LiveCounts {
  std::uint32_t frames_accepted = 0;
  std::uint32_t frames_dropped_for_job = 0;  ///< the work that was due was not finished
  std::uint32_t frames_with_pose = 0;
  std::uint32_t first_pose_frame = UINT32_MAX;  ///< accepted frames before it
  std::int64_t last_step_us = 0;
  Moment last_step;               ///< when it ended
  DeadlineMonitor deadline{0.0};  ///< of the steps
  DurationHistogram step;
  DurationHistogram publish;  ///< a step's jobs to the worker, its packets to all transports and
                              ///< the run's own file
  DurationHistogram latency;  ///< frame available to packets handed over
  /// The part of it in which the frame's thread had a processor: the latency on a machine with a
  /// processor for it.
  DurationHistogram latency_cpu;
  /// Processor time of the frame's thread a frame, all but the step's: camera, recording, packets,
  /// checkpoint, telemetry.
  DurationHistogram outside_cpu;
};

}  // namespace polhode::platform
