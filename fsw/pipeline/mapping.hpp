// What a new keyframe sets off: new landmarks, adjustment, culling.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// Joint adjustment of a map that has just begun, or begun anew with the keyframe of this number,
/// with the landmarks that those keyframes give beyond the start's tracks.
void settle_map(std::uint32_t first_keyframe, Component::State* state);

/// Makes this frame a keyframe when it should be one, extends the map by it, adjusts, culls; the
/// frame's pose in `localised` becomes the adjusted one.
void extend_map(Component::State* state);

/// Joint adjustment of all keyframes and landmarks.
void adjust_all(int iterations_max, Component::State* state);

/// Sightings and landmarks that do not fit go; the noise scale is measured anew.
void cull_map(Component::State* state);

/// Appends to the poses so far; the oldest goes when the table is full.
void remember_pose(std::int64_t timestamp_ns,
                   const Pose& pose,
                   const PoseCovariance& covariance,
                   Component::State* state);

}  // namespace polhode
