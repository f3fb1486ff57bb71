#include "app/live_camera_choice.hpp"

#include <fmt/format.h>

#include "app/live_report.hpp"
#include "app/warnings.hpp"
#include "camera/replay/played_sequence.hpp"
#include "camera/v4l2/v4l2_camera.hpp"
#include "errors.hpp"
#include "os/linux/clock.hpp"

namespace polhode::platform {
namespace {

/// Offset from the kernel's monotonic clock to UTC. Taken once: a clock that is set later must not
/// make time jump.
std::int64_t utc_offset_ns() { return clock_ns(CLOCK_REALTIME) - clock_ns(CLOCK_MONOTONIC); }

V4l2Options device_options(const DeviceOptions& device, const CameraParameters& camera) {
  constexpr std::int64_t kMicrosecond_ns = 1000;
  const PixelPacking* packing = find_packing(device.pixel_format);
  return {.request = {.path = device.source,
                      .format = {.width_px = camera.width_px,
                                 .height_px = camera.height_px,
                                 .fourcc = packing == nullptr ? 0 : packing->fourcc},
                      .rate_hz = device.rate_hz,
                      .buffers = device.buffers},
          .exposure_ns = device.exposure_us * kMicrosecond_ns,
          .gain = device.gain,
          .readout_ns = device.readout_us * kMicrosecond_ns,
          .clock_offset_ns = device.clock == "utc" ? utc_offset_ns() : 0,
          .backlog_frames_max = device.backlog_frames_max,
          .silence_max_ns = device.silence_ms_max * 1000 * kMicrosecond_ns};
}

}  // namespace

ChosenCamera::ChosenCamera(const std::filesystem::path& config,
                           const MachineOptions& machine,
                           Parameters* parameters)
    : config_(config), device_(machine.device) {
  if (device_.source.empty()) {
    throw UnusableInput(fmt::format(
        "{}: device.source is missing: allowed is a video device or the folder of a sequence",
        config_.string()));
  }
  if (std::filesystem::is_directory(device_.source)) {
    sequence_ = open_sequence(device_.source);
    parameters->camera = sequence_->camera;
    print_warnings(sequence_->warnings);
  }
  if (const auto problem = check(*parameters)) {
    throw UnusableInput(fmt::format("{}: {}", config_.string(), problem->message));
  }
  if (!sequence_) {
    check_configured_camera(config_, parameters->camera);
    refuse_unsuitable(parameters->camera);
  }
}

void ChosenCamera::refuse_unsuitable(const CameraParameters& parameters) const {
  DeviceStream device(linux_device_calls(), device_options(device_, parameters).request);
  if (device.check() == OpenResult::kUnsuitable) {
    throw UnusableInput(
        fmt::format("{}: device.source: unsuitable: {}", config_.string(), device.trouble()));
  }
}

LiveCamera& ChosenCamera::start(const CameraParameters& parameters) {
  if (sequence_) {
    play();
  } else {
    open_device(parameters);
  }
  return *camera_;
}

void ChosenCamera::play() {
  const std::int64_t start_ns =
      device_.sequence_start_ns > 0 ? device_.sequence_start_ns : linux_device_calls().now_ns();
  camera_ =
      std::make_unique<PlayedSequence>(*sequence_,
                                       PlayOptions{.speed = device_.sequence_speed,
                                                   .passes = device_.sequence_passes,
                                                   .backlog_frames_max = device_.backlog_frames_max,
                                                   .start_ns = start_ns});
}

void ChosenCamera::open_device(const CameraParameters& parameters) {
  auto camera =
      std::make_unique<V4l2Camera>(linux_device_calls(), device_options(device_, parameters));
  if (camera->open() == OpenResult::kStreaming) {
    const OfferedFormat& format = camera->stream().format();
    report_line("camera: %s, %s %dx%d, %.4g Hz, %zu buffers",
                device_.source.c_str(),
                fourcc_text(format.fourcc).c_str(),
                format.width_px,
                format.height_px,
                camera->stream().rate_hz(),
                camera->stream().buffers());
  }
  camera_ = std::move(camera);
}

}  // namespace polhode::platform
