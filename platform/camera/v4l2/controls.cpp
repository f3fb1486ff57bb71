#include "camera/v4l2/controls.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>

namespace polhode::platform {
namespace {

bool set_control(DeviceCalls& calls, int device, const ControlRange& range, std::int64_t setting) {
  v4l2_control control{};
  control.id = range.id;
  control.value = static_cast<std::int32_t>(setting);
  return range.present && calls.ioctl(device, VIDIOC_S_CTRL, &control) >= 0;
}

std::int64_t get_control(DeviceCalls& calls, int device, const ControlRange& range) {
  v4l2_control control{};
  control.id = range.id;
  const bool known = range.present && calls.ioctl(device, VIDIOC_G_CTRL, &control) >= 0;
  return known ? control.value : 0;
}

}  // namespace

ControlRange find_control(DeviceCalls& calls, int device, std::uint32_t id) {
  v4l2_queryctrl query{};
  query.id = id;
  if (calls.ioctl(device, VIDIOC_QUERYCTRL, &query) < 0 ||
      (query.flags & (V4L2_CTRL_FLAG_DISABLED | V4L2_CTRL_FLAG_READ_ONLY)) != 0) {
    return {};
  }
  return {.present = true,
          .id = id,
          .low = query.minimum,
          .high = query.maximum,
          .step = std::max<std::int64_t>(query.step, 1)};
}

std::int64_t nearest_setting(const ControlRange& range, double value) {
  const double steps = (value - static_cast<double>(range.low)) / static_cast<double>(range.step);
  const double most =
      std::floor(static_cast<double>(range.high - range.low) / static_cast<double>(range.step));
  const double within = std::clamp(std::round(steps), 0.0, most);
  return range.low + static_cast<std::int64_t>(within) * range.step;
}

void ExposureControls::find(DeviceCalls& calls, int device) {
  const ControlRange automatic = find_control(calls, device, V4L2_CID_EXPOSURE_AUTO);
  (void)set_control(calls, device, automatic, V4L2_EXPOSURE_MANUAL);
  exposure_ = find_control(calls, device, V4L2_CID_EXPOSURE_ABSOLUTE);
  gain_ = find_control(calls, device, V4L2_CID_GAIN);
  exposure_setting_ = get_control(calls, device, exposure_);
  gain_setting_ = get_control(calls, device, gain_);
}

bool ExposureControls::set_exposure(DeviceCalls& calls, int device, std::int64_t requested_ns) {
  const double units = static_cast<double>(requested_ns) / static_cast<double>(kUnit_ns);
  const std::int64_t setting = nearest_setting(exposure_, units);
  if (!set_control(calls, device, exposure_, setting)) {
    return false;
  }
  exposure_setting_ = setting;
  return true;
}

bool ExposureControls::set_gain(DeviceCalls& calls, int device, double fraction) {
  const double value =
      static_cast<double>(gain_.low) + fraction * static_cast<double>(gain_.high - gain_.low);
  const std::int64_t setting = nearest_setting(gain_, value);
  if (!set_control(calls, device, gain_, setting)) {
    return false;
  }
  gain_setting_ = setting;
  return true;
}

}  // namespace polhode::platform
