// TRACKING and LOST: the pose of each frame from the map, which grows by it.
#pragma once

#include <optional>

#include "geometry/pose_prediction.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// Finds the frame's pose by optical flow or guided matching, whichever the predicted image motion
/// calls for, else by relocalisation; extends the map. A frame without a pose is collected for a
/// new start.
/// @param predicted  the pose by the motion so far; nothing where no pose is known.
void track(const std::optional<PosePrediction>& predicted, Component::State* state);

/// A frame without a pose, in which it was looked for: the mode is LOST.
void lose_target(Component::State* state);

}  // namespace polhode
