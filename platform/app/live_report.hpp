// Reports on a live run: a line on stderr when something happens and every few seconds, and
// run.json.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "app/live_counts.hpp"
#include "camera/live_camera.hpp"
#include "os/linux/service_manager.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

class LiveReport {
 public:
  LiveReport(ServiceManager& manager, int period_s);

  void stepped(const StepOutput& out) { last_ = out.motion; }
  /// Once a turn of the loop: reports changes, and the state every period.
  void passed(const LiveCamera& camera, const LiveCounts& counts, std::int64_t now_ns);
  /// Once a turn of the loop: reports failed writes to the disk, the first at once, later ones no
  /// more often than trouble of the camera.
  /// @return true when it has reported.
  bool written(const WriteFailures& failures, std::int64_t now_ns);
  [[nodiscard]] const MotionState& last() const { return last_; }

 private:
  void report_state(const LiveCamera& camera, const LiveCounts& counts);

  ServiceManager& manager_;
  std::int64_t period_ns_;
  std::int64_t due_ns_ = 0;
  CameraCounters reported_;
  std::array<char, 80> reported_state_{};  ///< its first characters, which detect a new one
  std::int64_t trouble_due_ns_ = 0;        ///< lines about trouble come no faster than this
  WriteFailures reported_failures_;
  std::int64_t failures_due_ns_ = 0;
  MotionState last_;
};

/// Frames that the camera gave and the component never saw: late, out of time, or dropped for
/// unfinished work.
std::uint32_t frames_passed_over(const CameraCounters& camera, const LiveCounts& counts);

/// A line of its own on stderr, cut at 200 characters.
void report_line(const char* format, ...) __attribute__((format(printf, 1, 2)));

}  // namespace polhode::platform
