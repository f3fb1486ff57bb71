// All packets of a step but their content's origin: what is sent when.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// Empties the stream, so that what commands report goes with this step's packets.
void begin_telemetry(Component::State* state);

/// The motion packet of this step, then model, prediction, shape and housekeeping when they are
/// due, events, and parts of a requested cloud.
void send_telemetry(FrameUse use, const MotionState& motion, Component::State* state);

}  // namespace polhode
