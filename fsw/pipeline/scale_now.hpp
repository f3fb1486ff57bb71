// Metres per map unit, as soon as what carries the scale has been seen.
#pragma once

#include <cstdint>
#include <span>

#include "pipeline/state.hpp"
#include "shape/shape.hpp"

namespace polhode {

/// Where the configuration names a length or a range in a frame, and that frame is this one or a
/// keyframe, they are read, once. Afterwards lengths are published in metres, unless readings
/// contradict each other.
void measure_scale(Component::State* state);

/// The same from any view of that frame: its pose and the landmarks seen in it. False where nothing
/// more can be told.
bool measure_scale_in(const Pose& pose,
                      std::span<const Eigen::Vector3d> landmarks_T,
                      Component::State* state);

/// From a found shape in map units, where the configuration names a diameter or an edge.
bool measure_scale_of(const Shape& shape, Component::State* state);

/// Whether a named length or range still waits for its frame.
[[nodiscard]] bool waits_for_frame(const Component::State& state);

}  // namespace polhode
