// A sequence from disk as a live camera: its frames come when they are due, and those that are due
// while the estimator is busy are passed over, as with a real one.
#pragma once

#include <cstdint>
#include <string>

#include "camera/live_camera.hpp"
#include "camera/replay/file_camera.hpp"
#include "camera/replay/sequence.hpp"

namespace polhode::platform {

struct PlayOptions {
  double speed = 1.0;          ///< 0: each frame is due when it is requested
  int passes = 1;              ///< forth, back, forth ...: time goes on, the motion turns round
  int backlog_frames_max = 1;  ///< due frames that may wait behind the oldest
  std::int64_t start_ns = 0;   ///< monotonic time at which the first frame is due
};

/// A frame of all passes.
struct PlayedFrame {
  std::size_t index = 0;  ///< in the sequence
  std::int64_t timestamp_ns = 0;
};

/// @param position counts through all passes; the turning frames come once.
PlayedFrame played_frame(const Sequence& sequence, std::size_t position);
std::size_t played_frames(const Sequence& sequence, int passes);

class PlayedSequence final : public LiveCamera {
 public:
  /// @param sequence must outlive the camera.
  PlayedSequence(const Sequence& sequence, const PlayOptions& options);

  Arrival next(int timeout_ms, Frame* frame) override;
  [[nodiscard]] std::int64_t available_ns() const override { return available_ns_; }
  [[nodiscard]] bool frames_wait() const override { return options_.speed == 0.0; }
  [[nodiscard]] const CameraCounters& counters() const override { return counters_; }
  [[nodiscard]] std::string_view state() const override { return "playing"; }
  void set_exposure(std::int64_t /*exposure_ns*/, double /*gain*/) override {}

 private:
  [[nodiscard]] std::int64_t due_ns(std::size_t position) const;
  void pass_over_late(std::int64_t now_ns);
  void read_ahead();

  const Sequence& sequence_;
  PlayOptions options_;
  FileCamera files_;
  std::size_t frames_;
  std::size_t position_ = 0;
  Frame ahead_;            ///< of position_, where that has been read
  bool has_read_ = false;  ///< ahead_ is position_'s
  std::int64_t available_ns_ = 0;
  CameraCounters counters_;
};

}  // namespace polhode::platform
