// Events that follow from what changed since the last step.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// Compares the component with what was told so far, and reports the differences.
void tell_events(FrameUse use, const MotionState& motion, Component::State* state);

}  // namespace polhode
