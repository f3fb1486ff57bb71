// Interface of a live run's camera. A frame, or nothing yet; trouble is counted and reported, never
// thrown while the run goes on.
#pragma once

#include <cstdint>
#include <string_view>

#include "pipeline/component.hpp"

namespace polhode::platform {

enum class Arrival : std::uint8_t {
  kFrame,
  kNothing,  ///< not within the time-out; the camera may be away
  kEnded,    ///< there will be no more
};

/// Since the camera was made. Everything that was lost is in one of these.
struct CameraCounters {
  std::uint32_t frames = 0;              ///< handed out, readable or not
  std::uint32_t frames_damaged = 0;      ///< of these: error flag, too short, not decodable
  std::uint32_t frames_missing = 0;      ///< gaps in the device's own numbers
  std::uint32_t frames_late = 0;         ///< taken by the camera, passed over for a newer one
  std::uint32_t frames_out_of_time = 0;  ///< time stamp not after the one before: passed over
  std::uint32_t timeouts = 0;            ///< waits that brought no frame
  std::uint32_t stream_errors = 0;       ///< the stream failed and was opened again
  std::uint32_t disconnects = 0;         ///< the device went away
  std::uint32_t busy = 0;                ///< attempts that found another program on it
  std::uint32_t attempts = 0;            ///< at opening the device
  std::uint32_t opened = 0;              ///< times that a stream was started
};

/// How a camera is set, and how it can be.
struct CameraExposure {
  bool settable = false;  ///< the rest is meaningful
  std::int64_t exposure_ns = 0;
  std::int64_t exposure_min_ns = 0;
  std::int64_t exposure_max_ns = 0;
  bool has_gain = false;
  double gain = 0.0;  ///< fraction of the control's range
};

class LiveCamera {
 public:
  virtual ~LiveCamera() = default;

  /// The next frame within `timeout_ms`; its image is valid until the next call. Never blocks
  /// longer, opens the device (again) when it is due.
  virtual Arrival next(int timeout_ms, Frame* frame) = 0;

  /// Monotonic time at which the frame handed out last was there to be taken.
  [[nodiscard]] virtual std::int64_t available_ns() const = 0;

  /// Does a frame stay until it is requested? Then none is dropped for unfinished work.
  [[nodiscard]] virtual bool frames_wait() const { return false; }

  [[nodiscard]] virtual const CameraCounters& counters() const = 0;
  /// One line: the camera's state, and the reason.
  [[nodiscard]] virtual std::string_view state() const = 0;

  /// Requests another exposure and gain; a camera without these controls ignores it.
  virtual void set_exposure(std::int64_t exposure_ns, double gain) = 0;
  [[nodiscard]] virtual CameraExposure exposure() const { return {}; }
};

}  // namespace polhode::platform
