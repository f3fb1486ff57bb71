// Does a step keep its time?
#pragma once

#include <algorithm>
#include <cstdint>

namespace polhode::platform {

/// Counts steps that took longer than a frame interval. The caller decides what follows: a late
/// result never changes a packet, it only makes the next camera frame wait or be dropped.
class DeadlineMonitor {
 public:
  /// @param frame_ms  time of a step; 0: none is set.
  explicit DeadlineMonitor(double frame_ms)
      : allowed_us_(static_cast<std::int64_t>(1000.0 * frame_ms)) {}

  /// @return true when this step kept its time.
  bool add(std::int64_t step_us) {
    worst_us_ = std::max(worst_us_, step_us);
    const bool late = allowed_us_ > 0 && step_us > allowed_us_;
    missed_ += late ? 1 : 0;
    in_a_row_ = late ? in_a_row_ + 1 : 0;
    in_a_row_max_ = std::max(in_a_row_max_, in_a_row_);
    return !late;
  }

  [[nodiscard]] std::int64_t allowed_us() const { return allowed_us_; }
  [[nodiscard]] std::int64_t worst_us() const { return worst_us_; }
  [[nodiscard]] std::uint64_t missed() const { return missed_; }
  [[nodiscard]] std::uint64_t missed_in_a_row_max() const { return in_a_row_max_; }

 private:
  std::int64_t allowed_us_;
  std::int64_t worst_us_ = 0;
  std::uint64_t missed_ = 0;
  std::uint64_t in_a_row_ = 0;
  std::uint64_t in_a_row_max_ = 0;
};

}  // namespace polhode::platform
