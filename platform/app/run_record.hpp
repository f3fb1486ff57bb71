// Record of a replay's frames for the summary.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "app/camera_check.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

struct ModeChange {
  std::size_t frame = 0;
  std::int64_t timestamp_ns = 0;
  Mode mode = Mode::kIdle;
};

struct BadFrame {
  std::size_t frame = 0;
  std::int64_t timestamp_ns = 0;
  FrameUse use = FrameUse::kUnreadable;
  FrameVerdict verdict;
  std::string reason;
};

/// Lists are cut at these lengths, so that a broken sequence cannot make the summary endless; the
/// counters stay exact.
inline constexpr std::size_t kBadFramesListed = 100;
inline constexpr std::size_t kModeChangesListed = 1000;

struct RunRecord {
  std::size_t frames_in = 0;
  std::size_t frames_with_pose = 0;
  std::size_t mode_changes_total = 0;
  std::optional<std::size_t> first_pose_frame;
  std::uint32_t first_target_frame = 0;  ///< of that pose
  std::string model;  ///< file that the run began with, in T number 1; empty: none
  std::vector<ModeChange> mode_changes;
  std::vector<BadFrame> bad_frames;
  MotionState last;  ///< of the last frame
  CameraReport camera;
};

/// Was the target recognised by the model that the run began with?
inline bool is_recognised(const RunRecord& record) {
  return !record.model.empty() && record.first_pose_frame && record.first_target_frame == 1;
}

/// Adds one frame. @param refusal why the camera could not read it; empty when it could.
void add_frame(RunRecord& record,
               std::size_t frame,
               const StepOutput& out,
               const std::string& refusal,
               std::int64_t timestamp_ns);

const char* use_name(FrameUse use);
const char* fault_name(FrameFault fault);

}  // namespace polhode::platform
