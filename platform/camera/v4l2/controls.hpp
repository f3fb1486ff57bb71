// Exposure and gain of a device, in SI units.
#pragma once

#include <cstdint>

#include "camera/v4l2/device_calls.hpp"

namespace polhode::platform {

struct ControlRange {
  bool present = false;
  std::uint32_t id = 0;
  std::int64_t low = 0;
  std::int64_t high = 0;
  std::int64_t step = 1;
};

/// A control that the device has and that can be set; else not present.
ControlRange find_control(DeviceCalls& calls, int device, std::uint32_t id);

/// @return `value` as the nearest one that the control can take.
std::int64_t nearest_setting(const ControlRange& range, double value);

class ExposureControls {
 public:
  /// Looks for the controls and puts automatic exposure off, so that nobody else changes them.
  /// Exposure is V4L2's absolute one, in units of 100 us: the other, in units of the device's own,
  /// cannot be set in seconds and is left alone.
  void find(DeviceCalls& calls, int device);

  /// @return false when the device refuses, or has no such control.
  bool set_exposure(DeviceCalls& calls, int device, std::int64_t requested_ns);
  /// @param fraction of the control's range, 0 .. 1.
  bool set_gain(DeviceCalls& calls, int device, double fraction);

  /// As the device has it now; `otherwise_ns` where it does not give it.
  [[nodiscard]] std::int64_t exposure_ns(std::int64_t otherwise_ns) const {
    return exposure_.present && exposure_setting_ > 0 ? exposure_setting_ * kUnit_ns : otherwise_ns;
  }
  /// As the device has it now, as a fraction of the control's range; 0 without one.
  [[nodiscard]] double gain_fraction() const {
    const auto span = static_cast<double>(gain_.high - gain_.low);
    return gain_.present && span > 0.0 ? static_cast<double>(gain_setting_ - gain_.low) / span
                                       : 0.0;
  }
  [[nodiscard]] const ControlRange& exposure() const { return exposure_; }
  [[nodiscard]] const ControlRange& gain() const { return gain_; }

  static constexpr std::int64_t kUnit_ns = 100'000;

 private:
  ControlRange exposure_;
  ControlRange gain_;
  std::int64_t exposure_setting_ = 0;
  std::int64_t gain_setting_ = 0;
};

}  // namespace polhode::platform
