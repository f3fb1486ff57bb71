// The modes of the component, and all that changes them.
#pragma once

#include <cstdint>

#include "motion/motion_state.hpp"

namespace polhode {

enum class ModeEvent : std::uint8_t {
  kHoldCommanded,
  kResumedWithMap,
  kResumedWithoutMap,
  kFrameComes,
  kMapBegun,
  kPoseFound,
  kPoseNotFound,
  kPosePredicted,
  kTargetReset,
  kWarmStartWithMap,
  kWarmStartWithoutMap,
};

/// The state of this room.
struct ModeState {
  Mode now = Mode::kIdle;
  bool held = false;  ///< by command: frames are not looked at, and the mode is idle
};

/// Was there a pose in the last frame that could be looked at?
inline bool has_target(const ModeState& mode) {
  return mode.now == Mode::kTracking || mode.now == Mode::kCoasting;
}

/// Carries out the one transition that the table has for this event; without one nothing changes.
void change_mode(ModeEvent event, ModeState* mode);

}  // namespace polhode
