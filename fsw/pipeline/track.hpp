// TRACKING and LOST: the pose of each frame from the map.
#pragma once

#include <optional>

#include "pipeline/state.hpp"

namespace polhode {

/// Finds the frame's pose by optical flow or guided matching, whichever the predicted image motion
/// calls for, else by relocalisation; extends the map. Sets `pose_valid`, `localised` and the mode.
/// @param predicted  the pose by the motion so far; nothing where no pose is known.
void track(const std::optional<PosePrediction>& predicted, Component::State* state);

/// Does this frame's pose, in `localised`, agree with the motion so far? The prediction knows its
/// own error and how sharply a free body's motion may bend; a map's depth is known to some percent,
/// which falsifies a step by as much. A young motion has hardly been checked: there the bound is
/// what Euler's equation allows (the rate changes by at most |w|^2 a second, a step of a radians by
/// a^2) and a degree. A map that has just been moved under poses that it gave leaves the prediction
/// off by as much.
/// @param start_checks  a start's poses count as a check. Where its map is sheared all of them are
/// off together, and refuse the first
///   right one.
bool plausible(const PosePrediction& predicted, bool start_checks, const Component::State& state);

/// This frame's pose by descriptors about a predicted one, in a circle that grows when too few
/// agree; in `localised`.
bool find_about(const PosePrediction& predicted, Component::State* state);

/// This frame's pose by its descriptors alone, over all keyframes; in `localised`.
bool relocalise_frame(Component::State* state);

}  // namespace polhode
