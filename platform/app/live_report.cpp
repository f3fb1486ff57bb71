#include "app/live_report.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include "app/motion_csv.hpp"

namespace polhode::platform {
namespace {

constexpr std::int64_t kReportSecond_ns = 1'000'000'000;

/// Trouble that is worth a line at once.
std::uint32_t trouble(const CameraCounters& c) {
  return c.opened + c.disconnects + c.stream_errors + c.busy + c.frames_damaged + c.frames_missing;
}

}  // namespace

void report_line(const char* format, ...) {
  std::array<char, 200> line{};
  std::va_list arguments;
  va_start(arguments, format);
  const int length = std::vsnprintf(line.data(), line.size() - 1, format, arguments);
  va_end(arguments);
  const auto bytes =
      static_cast<std::size_t>(std::clamp(length, 0, static_cast<int>(line.size()) - 2));
  line[bytes] = '\n';
  // One call: lines of several threads do not mix. Nothing can be done about a closed stderr.
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line.data(), bytes + 1);
}

std::uint32_t frames_passed_over(const CameraCounters& camera, const LiveCounts& counts) {
  return camera.frames_late + camera.frames_out_of_time + counts.frames_dropped_for_job;
}

LiveReport::LiveReport(ServiceManager& manager, int period_s)
    : manager_(manager), period_ns_(period_s * kReportSecond_ns) {}

void LiveReport::passed(const LiveCamera& camera, const LiveCounts& counts, std::int64_t now_ns) {
  const CameraCounters& c = camera.counters();
  const std::string_view state = camera.state();
  const std::string_view state_begins = state.substr(0, reported_state_.size() - 1);
  const bool news = trouble(c) != trouble(reported_) || state_begins != reported_state_.data();
  if (news && now_ns >= trouble_due_ns_) {
    trouble_due_ns_ = now_ns + kReportSecond_ns;
    reported_ = c;
    reported_state_.fill('\0');
    std::copy(state_begins.begin(), state_begins.end(), reported_state_.begin());
    report_line("camera: %.*s (opened %u, gone %u, failed %u, busy %u; damaged %u, missing %u)",
                static_cast<int>(state.size()),
                state.data(),
                c.opened,
                c.disconnects,
                c.stream_errors,
                c.busy,
                c.frames_damaged,
                c.frames_missing);
  }
  if (now_ns >= due_ns_) {
    due_ns_ = now_ns + period_ns_;
    report_state(camera, counts);
  }
}

bool LiveReport::written(const WriteFailures& failures, std::int64_t now_ns) {
  if (failures == reported_failures_ || now_ns < failures_due_ns_) {
    return false;
  }
  failures_due_ns_ = now_ns + kReportSecond_ns;
  reported_failures_ = failures;
  report_line(
      "disk: not written since the start: packets of %llu steps, %llu checkpoints, %llu records, "
      "%llu packets of files",
      static_cast<unsigned long long>(failures.packets),
      static_cast<unsigned long long>(failures.checkpoints),
      static_cast<unsigned long long>(failures.records),
      static_cast<unsigned long long>(failures.streamed));
  return true;
}

void LiveReport::report_state(const LiveCamera& camera, const LiveCounts& counts) {
  std::array<char, 160> line{};
  std::snprintf(line.data(),
                line.size(),
                "%s, %u frames, %u with a pose, %u passed over, step p99 %.1f ms",
                mode_name(last_.mode),
                counts.frames_accepted,
                counts.frames_with_pose,
                frames_passed_over(camera.counters(), counts),
                1e-3 * static_cast<double>(counts.step.percentile_us(0.99)));
  report_line("%s", line.data());
  manager_.status(line.data());
}

}  // namespace polhode::platform
