// The camera of a live run: a V4L2 device that is opened again when it fails, its frames as gray
// images with the time of mid-exposure. After the first stream no memory is taken.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/earlier_times.hpp"
#include "base/fixed_vector.hpp"
#include "camera/live_camera.hpp"
#include "camera/v4l2/convert.hpp"
#include "camera/v4l2/device_stream.hpp"
#include "camera/v4l2/frame_time.hpp"

namespace polhode::platform {

struct V4l2Options {
  DeviceRequest request;
  std::int64_t exposure_ns = 0;      ///< set at start; 0: as the device has it
  double gain = -1.0;                ///< fraction of the control's range; below 0: as it is
  std::int64_t readout_ns = 0;       ///< end of exposure to the time stamp
  std::int64_t clock_offset_ns = 0;  ///< added to every time stamp
  int backlog_frames_max =
      1;  ///< filled buffers that may wait; beyond it the oldest are passed over
  std::int64_t silence_max_ns =
      2'000'000'000;  ///< a stream without frames for this long is opened again
};

class V4l2Camera final : public LiveCamera {
 public:
  V4l2Camera(DeviceCalls& calls, const V4l2Options& options);

  Arrival next(int timeout_ms, Frame* frame) override;
  [[nodiscard]] std::int64_t available_ns() const override { return available_ns_; }
  [[nodiscard]] const CameraCounters& counters() const override { return counters_; }
  [[nodiscard]] std::string_view state() const override { return state_.data(); }
  void set_exposure(std::int64_t exposure_ns, double gain) override;
  /// No longer than the time from frame to frame.
  [[nodiscard]] CameraExposure exposure() const override;

  /// One attempt, at once. Called at start, so that an unusable device is refused there. The device
  /// that streamed first is the camera from then on. One that was unplugged may return under
  /// another number (its own is taken as long as a process has the old node open), and is searched
  /// for there; another device is not taken.
  OpenResult open();
  [[nodiscard]] const DeviceStream& stream() const { return stream_; }

 private:
  OpenResult open_wherever_it_is();
  OpenResult open_elsewhere();
  Arrival wait_to_open(int timeout_ms);
  bool gather(int timeout_ms);
  void pass_over_late();
  Arrival hand_out(Frame* frame);
  void give_back(const TakenBuffer& buffer);
  void end_stream(TakeResult why);
  [[nodiscard]] std::int64_t filled_ns(const TakenBuffer& buffer) const;
  [[nodiscard]] std::int64_t exposure_at(std::int64_t stamp_ns) const;
  void set_state(const char* what, std::string_view detail);

  DeviceCalls& calls_;
  V4l2Options options_;
  DeviceStream stream_;
  std::optional<GrayConverter> converter_;
  OfferedFormat first_format_;
  DeviceIdentity first_identity_;
  FixedVector<TakenBuffer, kDeviceBuffers> ready_;  ///< oldest first
  std::optional<TakenBuffer> taken_;                ///< the estimator looks at it
  SequenceWatch sequence_;
  Backoff backoff_;
  std::int64_t waited_ns_ =
      0;  ///< since the stream last brought something; the estimator's time does not count
  std::int64_t exposure_before_ns_ = 0;  ///< until exposure_changed_ns_, on the clock of the stamps
  std::int64_t exposure_changed_ns_ = INT64_MIN;
  std::int64_t available_ns_ = 0;
  std::int64_t last_timestamp_ns_ = INT64_MIN;
  EarlierTimes earlier_times_;
  CameraCounters counters_;
  std::array<char, 200> state_{};
};

}  // namespace polhode::platform
