// An open capture device with its ring of mapped buffers: opened, configured, started, read and
// closed. Makes one attempt; V4l2Camera decides what follows a failure.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/fixed_vector.hpp"
#include "camera/v4l2/controls.hpp"
#include "camera/v4l2/device_calls.hpp"
#include "camera/v4l2/formats.hpp"
#include "camera/v4l2/frame_time.hpp"

struct v4l2_capability;

namespace polhode::platform {

/// The number of buffers that drivers give (V4L2 itself allows 32).
inline constexpr std::size_t kDeviceBuffers = 32;

struct DeviceRequest {
  std::string path;
  FormatRequest format;
  double rate_hz = 10.0;
  int buffers = 4;
};

/// Identity of a device: its name and its place in the machine. The number of its node may change
/// while the device is away.
struct DeviceIdentity {
  std::array<char, 16> driver{};
  std::array<char, 32> card{};
  std::array<char, 32> bus{};

  bool operator==(const DeviceIdentity&) const = default;
};

enum class OpenResult : std::uint8_t {
  kStreaming,
  kAbsent,      ///< no such node, or it has gone meanwhile
  kOther,       ///< not the device that is insisted on; nothing was set
  kBusy,        ///< another program has it
  kUnsuitable,  ///< no capture device, or without the requested format: trying again will not help
  kFailed,      ///< a call failed that should not
};

enum class TakeResult : std::uint8_t { kBuffer, kNothing, kGone, kBroken };

/// One filled buffer, out of the kernel's queue until it is given back.
struct TakenBuffer {
  std::uint32_t index = 0;
  std::uint32_t sequence = 0;
  std::int64_t stamp_ns = 0;  ///< of the kernel; of now where the driver gives none
  StampedAt stamped_at = StampedAt::kEndOfFrame;
  std::int64_t taken_ns = 0;  ///< when it came out of the queue
  bool damaged = false;       ///< by the device's own word
  std::span<const std::uint8_t> bytes;
};

class DeviceStream {
 public:
  DeviceStream(DeviceCalls& calls, DeviceRequest request)
      : calls_(calls), request_(std::move(request)) {}
  ~DeviceStream() { close(); }
  DeviceStream(const DeviceStream&) = delete;
  DeviceStream& operator=(const DeviceStream&) = delete;

  /// @param path of the node: the requested one, or another of the same device.
  OpenResult open(const char* path);
  OpenResult open() { return open(request_.path.c_str()); }
  /// Whether the requested device is usable; nothing is streamed, and it is closed again.
  OpenResult check();
  /// From now on no other device is taken.
  void insist_on(const DeviceIdentity& identity) { only_ = identity; }
  void close();
  [[nodiscard]] bool is_open() const { return device_ >= 0; }

  /// Waits for a filled buffer and takes it.
  /// @param timeout_ms 0: without waiting.
  TakeResult take(int timeout_ms, TakenBuffer* taken);
  /// @return false when the device does not take it: the stream is no more.
  bool give_back(std::uint32_t index);

  bool set_exposure(std::int64_t exposure_ns) {
    return is_open() && controls_.set_exposure(calls_, device_, exposure_ns);
  }
  bool set_gain(double fraction) {
    return is_open() && controls_.set_gain(calls_, device_, fraction);
  }

  [[nodiscard]] const char* path() const { return path_.data(); }  ///< of the last attempt
  /// All zero until the device has reported it.
  [[nodiscard]] const DeviceIdentity& identity() const { return identity_; }
  [[nodiscard]] const OfferedFormat& format() const { return format_; }
  [[nodiscard]] double rate_hz() const { return rate_hz_; }
  [[nodiscard]] std::size_t buffers() const { return ring_.size(); }
  [[nodiscard]] const ExposureControls& controls() const { return controls_; }
  [[nodiscard]] std::string_view trouble() const {
    return trouble_.data();
  }  ///< of the last call that failed

 private:
  struct Mapped {
    std::uint8_t* block = nullptr;
    std::size_t bytes = 0;
  };

  /// Opens the node and agrees on the format.
  OpenResult open_node(const char* path);
  OpenResult check_capabilities();
  OpenResult set_format();
  void set_interval();
  OpenResult map_ring();
  OpenResult start();
  OpenResult failed(const char* what, int error);

  DeviceCalls& calls_;
  DeviceRequest request_;
  std::array<char, 80> path_{};  ///< cut, for messages
  std::optional<DeviceIdentity> only_;
  DeviceIdentity identity_;
  int device_ = -1;
  std::uint32_t type_ = 0;  ///< capture_type()
  std::uint32_t planes_ = 1;
  bool streaming_ = false;
  OfferedFormat format_;
  double rate_hz_ = 0.0;
  ExposureControls controls_;
  FixedVector<Mapped, kDeviceBuffers> ring_;
  std::array<char, 200> trouble_{};
};

/// The kind of buffers that the device captures into, of one or of several planes; 0: it does not
/// capture by streaming.
std::uint32_t capture_type(const v4l2_capability& capability);

inline constexpr std::size_t kAskedFormats = 32;

/// Queries (TRY_FMT) the device's answer for each format that this driver can read.
/// @param type capture_type().
FixedVector<OfferedFormat, kAskedFormats> ask_formats(
    DeviceCalls& calls, int device, std::uint32_t type, int width_px, int height_px);

}  // namespace polhode::platform
