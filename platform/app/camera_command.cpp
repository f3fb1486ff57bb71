#include "app/camera_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "camera/v4l2/probe.hpp"
#include "errors.hpp"

namespace polhode::platform {
namespace {

void print_size(const SizeReport& size) {
  fmt::print("      {}{}x{}", size.range ? "up to " : "", size.width_px, size.height_px);
  if (!size.rates_hz.empty()) {
    fmt::print("  at {:.4g} Hz", fmt::join(size.rates_hz, ", "));
  }
  fmt::print("\n");
}

void print_control(const char* name, const char* unit, const ControlRange& range) {
  if (range.present) {
    fmt::print("  {}: {} .. {} in steps of {}{}\n", name, range.low, range.high, range.step, unit);
  } else {
    fmt::print("  {}: cannot be set\n", name);
  }
}

void print_use(const DeviceReport& report, const OfferedFormat& format) {
  const PixelPacking& packing = *find_packing(format.fourcc);
  const bool copied = packing.packing != Packing::kGray8 && packing.bits != 16;
  fmt::print("  Polhode would use: {} {}x{}, {} octets a frame, {}\n",
             packing.name,
             format.width_px,
             format.height_px,
             format.image_bytes,
             copied ? "converted to gray" : "read where it lies");
  if (format.width_px != report.width_px || format.height_px != report.height_px) {
    fmt::print("  (it is set to {}x{} now)\n", report.width_px, report.height_px);
  }
}

}  // namespace

void list_cameras() {
  const std::vector<std::string> nodes = video_nodes();
  if (nodes.empty()) {
    fmt::print("no video devices\n");
  }
  for (const std::string& node : nodes) {
    const DeviceReport report = probe_device(linux_device_calls(), node, 0, 0);
    const std::string verdict = !report.trouble.empty() ? report.trouble
                                : !report.captures      ? "does not capture"
                                : !report.would_use     ? "no format that Polhode reads"
                                                        : "usable";
    fmt::print("{}  {} ({}): {}\n", node, report.card, report.driver, verdict);
  }
}

void probe_camera(const ProbeArguments& arguments) {
  const DeviceReport report =
      probe_device(linux_device_calls(), arguments.device, arguments.width_px, arguments.height_px);
  if (!report.trouble.empty()) {
    throw UnusableInput(fmt::format("{}: {}", report.path, report.trouble));
  }
  fmt::print("{}: {}, driver {}, at {}\n", report.path, report.card, report.driver, report.bus);
  if (!report.captures) {
    throw UnusableInput(fmt::format("{}: does not capture by streaming", report.path));
  }
  fmt::print("  formats:\n");
  for (const FormatReport& format : report.formats) {
    fmt::print("    {:<8} {}{}\n",
               fourcc_text(format.fourcc),
               format.description,
               find_packing(format.fourcc) == nullptr ? " (not read by Polhode)" : "");
    for (const SizeReport& size : format.sizes) {
      print_size(size);
    }
  }
  print_control("exposure", " x 100 us", report.exposure);
  print_control("gain", "", report.gain);
  if (!report.would_use && !report.interlacing.empty()) {
    throw UnusableInput(
        fmt::format("{}: gives {}; allowed are progressive frames, all rows of one moment",
                    report.path,
                    report.interlacing));
  }
  if (!report.would_use) {
    throw UnusableInput(fmt::format("{}: nothing that Polhode reads at that size", report.path));
  }
  print_use(report, *report.would_use);
}

}  // namespace polhode::platform
