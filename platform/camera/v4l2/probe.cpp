#include "camera/v4l2/probe.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "camera/v4l2/device_stream.hpp"

namespace polhode::platform {
namespace {

// A bound for a device whose list never ends.
constexpr std::uint32_t kEntriesMax = 64;

template <std::size_t kSize>
std::string text_of(const std::uint8_t (&text)[kSize]) {
  const auto* letters = reinterpret_cast<const char*>(text);
  return {letters, ::strnlen(letters, kSize)};
}

std::vector<double> rates_of(DeviceCalls& calls,
                             int device,
                             std::uint32_t fourcc,
                             const SizeReport& size) {
  std::vector<double> rates_hz;
  for (std::uint32_t i = 0; i < kEntriesMax; ++i) {
    v4l2_frmivalenum entry{};
    entry.index = i;
    entry.pixel_format = fourcc;
    entry.width = static_cast<std::uint32_t>(size.width_px);
    entry.height = static_cast<std::uint32_t>(size.height_px);
    if (calls.ioctl(device, VIDIOC_ENUM_FRAMEINTERVALS, &entry) < 0) {
      break;
    }
    if (entry.type != V4L2_FRMIVAL_TYPE_DISCRETE) {  // the two ends of a range
      rates_hz.push_back(rate_hz({entry.stepwise.max.numerator, entry.stepwise.max.denominator}));
      rates_hz.push_back(rate_hz({entry.stepwise.min.numerator, entry.stepwise.min.denominator}));
      break;
    }
    rates_hz.push_back(rate_hz({entry.discrete.numerator, entry.discrete.denominator}));
  }
  return rates_hz;
}

std::vector<SizeReport> sizes_of(DeviceCalls& calls, int device, std::uint32_t fourcc) {
  std::vector<SizeReport> sizes;
  for (std::uint32_t i = 0; i < kEntriesMax; ++i) {
    v4l2_frmsizeenum entry{};
    entry.index = i;
    entry.pixel_format = fourcc;
    if (calls.ioctl(device, VIDIOC_ENUM_FRAMESIZES, &entry) < 0) {
      break;
    }
    const bool range = entry.type != V4L2_FRMSIZE_TYPE_DISCRETE;
    SizeReport size{
        .width_px = static_cast<int>(range ? entry.stepwise.max_width : entry.discrete.width),
        .height_px = static_cast<int>(range ? entry.stepwise.max_height : entry.discrete.height),
        .range = range,
        .rates_hz = {}};
    size.rates_hz = rates_of(calls, device, fourcc, size);
    sizes.push_back(std::move(size));
    if (range) {
      break;
    }
  }
  return sizes;
}

std::vector<FormatReport> formats_of(DeviceCalls& calls, int device, std::uint32_t type) {
  std::vector<FormatReport> formats;
  for (std::uint32_t i = 0; i < kEntriesMax; ++i) {
    v4l2_fmtdesc entry{};
    entry.index = i;
    entry.type = type;
    if (calls.ioctl(device, VIDIOC_ENUM_FMT, &entry) < 0) {
      break;
    }
    formats.push_back({.fourcc = entry.pixelformat,
                       .description = text_of(entry.description),
                       .sizes = sizes_of(calls, device, entry.pixelformat)});
  }
  return formats;
}

void ask(DeviceCalls& calls, int device, DeviceReport* report) {
  v4l2_capability capability{};
  if (const int answer = calls.ioctl(device, VIDIOC_QUERYCAP, &capability); answer < 0) {
    report->trouble = std::string("not a V4L2 device: ") + std::strerror(-answer);
    return;
  }
  report->card = text_of(capability.card);
  report->driver = text_of(capability.driver);
  report->bus = text_of(capability.bus_info);
  report->capture_type = capture_type(capability);
  report->captures = report->capture_type != 0;
  if (!report->captures) {
    return;
  }
  report->formats = formats_of(calls, device, report->capture_type);
  v4l2_format now{};
  now.type = report->capture_type;
  if (calls.ioctl(device, VIDIOC_G_FMT, &now) >= 0) {  // both structs begin with the size
    report->width_px = static_cast<int>(now.fmt.pix.width);
    report->height_px = static_cast<int>(now.fmt.pix.height);
  }
  report->exposure = find_control(calls, device, V4L2_CID_EXPOSURE_ABSOLUTE);
  report->gain = find_control(calls, device, V4L2_CID_GAIN);
}

}  // namespace

DeviceReport probe_device(DeviceCalls& calls,
                          const std::string& path,
                          int width_px,
                          int height_px) {
  DeviceReport report;
  report.path = path;
  const int device = calls.open(path.c_str());
  if (device < 0) {
    report.trouble = std::strerror(-device);
    return report;
  }
  ask(calls, device, &report);
  if (report.captures) {
    const FormatRequest request{.width_px = width_px > 0 ? width_px : report.width_px,
                                .height_px = height_px > 0 ? height_px : report.height_px};
    const auto offered =
        ask_formats(calls, device, report.capture_type, request.width_px, request.height_px);
    for (const OfferedFormat& format : offered.view()) {
      report.interlacing = interlacing(format.field);
    }
    if (const auto choice = choose_format(offered.view(), request)) {
      report.would_use = offered[*choice];
    }
  }
  calls.close(device);
  return report;
}

std::vector<std::string> video_nodes() {
  std::vector<std::pair<long, std::string>> nodes;
  std::error_code unreadable;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", unreadable)) {
    const std::string name = entry.path().filename();
    const std::string digits = name.rfind("video", 0) == 0 ? name.substr(5) : std::string();
    if (!digits.empty() && digits.size() < 6 &&
        digits.find_first_not_of("0123456789") == std::string::npos) {
      nodes.emplace_back(std::stol(digits), entry.path());
    }
  }
  std::sort(nodes.begin(), nodes.end());
  std::vector<std::string> paths;
  for (auto& [number, path] : nodes) {
    paths.push_back(std::move(path));
  }
  return paths;
}

}  // namespace polhode::platform
