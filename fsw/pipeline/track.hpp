// TRACKING and LOST: solves each frame's pose from the map, and extends the map.
#pragma once

#include <optional>

#include "geometry/pose_prediction.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// Finds the frame's pose by optical flow, by guided matching about the prediction, or by
/// relocalisation; extends the map. A frame without a pose is collected for a new initialisation.
/// @param predicted  the pose by the motion so far; empty without any pose so far.
void track(const std::optional<PosePrediction>& predicted, Component::State* state);

/// A frame without a pose after a search for the target: the mode becomes LOST.
void lose_target(Component::State* state);

}  // namespace polhode
