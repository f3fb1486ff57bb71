// Validity of this room's tables, for those read from a file or kept in memory that radiation
// reaches.
#pragma once

#include <cstdint>

#include "geometry/camera_model.hpp"
#include "map/drift.hpp"
#include "map/map.hpp"
#include "map/map_state.hpp"
#include "map/window.hpp"

namespace polhode {

/// Indices within their tables and of used slots, counts as they are, numbers finite, rotations
/// orthonormal, times not after `now_ns`.
/// @cost  linear in keyframes' features and in landmarks.
bool is_valid(const Map& map, const CameraModel& camera, std::int64_t now_ns);

bool is_valid(const MapDrift& drift);

/// The reference that optical flow follows.
bool is_valid(const FlowReference& reference, const Map& map);

/// Indices of the part of the map that an adjustment changes.
bool is_valid(const AdjustmentSnapshot& snapshot);

/// Parts of a map. A keyframe but for its features and their associations:
bool head_is_valid(const Keyframe& keyframe, const Map& map, std::int64_t now_ns);
bool is_valid(const Feature& feature, const CameraModel& camera);
/// No landmark, or a used slot of the map.
bool association_is_valid(LandmarkId landmark, const Map& map);
/// A landmark but for the number of its observations and its views:
bool head_is_valid(const Landmark& landmark, const Map& map);
bool views_are_valid(const Landmark& landmark, const Map& map);

}  // namespace polhode
