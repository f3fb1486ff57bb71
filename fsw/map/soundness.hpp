// Whether this room's tables hold what the room may compute with: after they came from a file, or
// lay in memory that radiation reaches.
#pragma once

#include <cstdint>

#include "geometry/camera_model.hpp"
#include "map/drift.hpp"
#include "map/map.hpp"

namespace polhode {

/// Indices within their tables and of used slots, counts as they are, numbers finite, rotations
/// orthonormal, times not after `now_ns`.
/// @cost  linear in keyframes' features and in landmarks.
bool is_sound(const Map& map, const CameraModel& camera, std::int64_t now_ns);

bool is_sound(const MapDrift& drift);

}  // namespace polhode
