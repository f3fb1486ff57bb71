#include "app/run_record.hpp"

#include <iterator>

#include "bus/code_names.hpp"

namespace polhode::platform {

const char* use_name(FrameUse use) {
  switch (use) {
    case FrameUse::kUsed:
      return "used";
    case FrameUse::kUnreadable:
      return "unreadable";
    case FrameUse::kDark:
      return "dark";
    case FrameUse::kWrongSize:
      return "wrong size";
    case FrameUse::kTimeNotIncreasing:
      return "time not increasing";
    case FrameUse::kHeld:
      return "held";
    case FrameUse::kFlat:
      return "flat";
    case FrameUse::kSaturated:
      return "saturated";
    case FrameUse::kFrozen:
      return "frozen";
    case FrameUse::kTorn:
      return "torn";
    case FrameUse::kBitErrors:
      return "bit errors";
  }
  return "";
}

const char* fault_name(FrameFault fault) {
  static_assert(std::size(bus::kFaultsNames) == kFrameFaults);
  return bus::kFaultsNames[static_cast<std::size_t>(fault)].name;
}

void add_frame(RunRecord& record,
               std::size_t frame,
               const StepOutput& out,
               const std::string& refusal,
               std::int64_t timestamp_ns) {
  const Mode mode = out.motion.mode;
  if (record.frames_in == 0 || mode != record.last.mode) {
    ++record.mode_changes_total;
    if (record.mode_changes.size() < kModeChangesListed) {
      record.mode_changes.push_back({.frame = frame, .timestamp_ns = timestamp_ns, .mode = mode});
    }
  }
  if ((out.use != FrameUse::kUsed || out.verdict.fault != FrameFault::kNone) &&
      record.bad_frames.size() < kBadFramesListed) {
    record.bad_frames.push_back({.frame = frame,
                                 .timestamp_ns = timestamp_ns,
                                 .use = out.use,
                                 .verdict = out.verdict,
                                 .reason = refusal});
  }
  if (is_measured(out.motion)) {
    ++record.frames_with_pose;
    if (!record.first_pose_frame) {
      record.first_pose_frame = frame;
      record.first_target_frame = out.motion.target_frame;
    }
  }
  ++record.frames_in;
  record.last = out.motion;
}

}  // namespace polhode::platform
