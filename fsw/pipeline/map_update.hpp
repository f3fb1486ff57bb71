// An adjustment's result on its way through the rooms: map, motion, what is asked for next.
#pragma once

#include "pipeline/adjustment.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// An adjustment may be prepared from this.
AdjustmentView adjustment_view(const Component::State& state);

/// The map takes a result over and is culled. What was derived from the adjusted keyframes follows:
/// this frame's pose, those remembered, the reference of optical flow, and what has come since.
/// Asks for the next adjustment if the map has grown meanwhile.
void take_adjustment(Component::State* state);

/// Joint adjustment of all keyframes and landmarks, here and now.
void adjust_all(int iterations_max, Component::State* state);

}  // namespace polhode
