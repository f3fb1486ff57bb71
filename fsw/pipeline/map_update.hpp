// Applies an adjustment's result to the map and the motion, and requests the next adjustment.
#pragma once

#include "pipeline/adjustment.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// Input of an adjustment, from this step's state.
AdjustmentView adjustment_view(const Component::State& state);

/// Puts a result into the map and culls it. Corrects everything derived from the adjusted
/// keyframes: this frame's pose, the stored poses, the reference of optical flow, and later
/// keyframes. Requests the next adjustment if the map has grown meanwhile.
void take_adjustment(Component::State* state);

/// Joint adjustment of all keyframes and landmarks, without a job.
void adjust_all(int iterations_max, Component::State* state);

}  // namespace polhode
