// The shape as far as the map shows it: estimated now and then as a job, and told on the bus.
#pragma once

#include "pipeline/component.hpp"
#include "shape/shape_state.hpp"

namespace polhode {

/// Asks for an estimate while the target is followed, the map has grown since the last one and
/// bus.shape_every_frames have passed; while there is none, a fifth of these.
void ask_for_shape(Component::State* state);

/// The estimate comes in; where there is none the last one stays.
void take_shape(Component::State* state);

/// T is another one from here on.
void forget_shape(Component::State* state);

/// Sends the packet when an estimate has come, and every bus.shape_every_frames frames.
void send_shape(const MotionState& motion, Component::State* state);

}  // namespace polhode
