// From the kernel's time stamp to the middle of the exposure, and from sequence numbers to gaps.
#pragma once

#include <cstdint>

namespace polhode::platform {

/// Moment that the time stamp of a buffer marks.
enum class StampedAt : std::uint8_t {
  kStartOfExposure,
  kEndOfFrame,  ///< the last pixel has arrived
};

struct ExposureTiming {
  StampedAt stamped_at = StampedAt::kEndOfFrame;
  std::int64_t exposure_ns = 0;
  std::int64_t readout_ns = 0;  ///< end of exposure to end of frame
};

/// @return the middle of the exposure, on the clock of the stamp.
constexpr std::int64_t mid_exposure_ns(std::int64_t stamp_ns, const ExposureTiming& timing) {
  const std::int64_t half_ns = timing.exposure_ns / 2;
  return timing.stamped_at == StampedAt::kStartOfExposure ? stamp_ns + half_ns
                                                          : stamp_ns - timing.readout_ns - half_ns;
}

/// Frames that the device took but did not deliver, by the numbers that it gives its frames.
class SequenceWatch {
 public:
  /// @return frames missing before this one. A number that repeats or runs back is a device that
  /// restarted its count, or does not count.
  std::uint32_t missing_before(std::uint32_t sequence) {
    const std::uint32_t step = sequence - last_;  // wraps with the counter
    const bool begun = begun_;
    begun_ = true;
    last_ = sequence;
    constexpr std::uint32_t kStepMax = 100'000;  // an hour at 30 frames a second: more is no gap
    return begun && step > 1 && step <= kStepMax ? step - 1 : 0;
  }
  void restart() { begun_ = false; }

 private:
  bool begun_ = false;
  std::uint32_t last_ = 0;
};

/// Times of retries after a failure: soon at first, then at intervals that double up to a bound.
class Backoff {
 public:
  static constexpr std::int64_t kFirst_ns = 50'000'000;
  // An unplugged camera that is back is found within this.
  static constexpr std::int64_t kLongest_ns = 1'000'000'000;

  [[nodiscard]] std::int64_t due_ns() const { return due_ns_; }
  void failed(std::int64_t now_ns) {
    due_ns_ = now_ns + step_ns_;
    step_ns_ = 2 * step_ns_ < kLongest_ns ? 2 * step_ns_ : kLongest_ns;
  }
  void succeeded() { *this = Backoff(); }

 private:
  std::int64_t step_ns_ = kFirst_ns;
  std::int64_t due_ns_ = 0;  ///< at once
};

}  // namespace polhode::platform
