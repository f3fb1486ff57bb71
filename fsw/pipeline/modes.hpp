// The modes of the component and the transitions between them.
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
  bool held = false;  ///< by command: frames are not processed, and the mode is IDLE
};

/// Did the last usable frame have a pose, measured or predicted?
inline bool has_target(const ModeState& mode) {
  return mode.now == Mode::kTracking || mode.now == Mode::kCoasting;
}

/// Carries out the transition that the table has for this event; without one nothing changes.
void change_mode(ModeEvent event, ModeState* mode);

}  // namespace polhode
