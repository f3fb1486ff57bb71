// Report on a device's capabilities. At start only: allocates freely.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "camera/v4l2/controls.hpp"
#include "camera/v4l2/device_calls.hpp"
#include "camera/v4l2/formats.hpp"

namespace polhode::platform {

struct SizeReport {
  int width_px = 0;  ///< of a range: the greatest
  int height_px = 0;
  bool range = false;
  std::vector<double> rates_hz;  ///< empty: not reported
};

struct FormatReport {
  std::uint32_t fourcc = 0;
  std::string description;
  std::vector<SizeReport> sizes;
};

struct DeviceReport {
  std::string path;
  std::string trouble;  ///< why nothing else is known; empty when it is
  std::string card;
  std::string driver;
  std::string bus;
  bool captures = false;  ///< by streaming
  std::uint32_t capture_type = 0;
  std::string_view interlacing;  ///< interlacing() at the requested size
  std::vector<FormatReport> formats;
  int width_px = 0;  ///< as it is set now
  int height_px = 0;
  ControlRange exposure;
  ControlRange gain;
  std::optional<OfferedFormat> would_use;  ///< at the requested size
};

/// @param width_px, height_px the size that would be used; 0: as the device is set.
DeviceReport probe_device(DeviceCalls& calls, const std::string& path, int width_px, int height_px);

/// Nodes /dev/video*, in order of their numbers.
std::vector<std::string> video_nodes();

}  // namespace polhode::platform
