// The scale, as soon as the frame that carries it has a pose.
#pragma once

#include <cstdint>
#include <span>

#include "pipeline/state.hpp"

namespace polhode {

/// Where the configuration names a length or a range in a frame, and that frame is this one or a
/// keyframe, metres per map unit are measured, once. Afterwards lengths are published in metres.
void measure_scale(Component::State* state);

/// The same from any view of that frame: its pose and the landmarks seen in it. False where it
/// cannot be told.
bool measure_scale_in(const Pose& pose,
                      std::span<const Eigen::Vector3d> landmarks_T,
                      Component::State* state);

}  // namespace polhode
