// Choice of keyframes: when a frame becomes one, and which one is removed for it.
#pragma once

#include <cstdint>

#include "map/localise.hpp"
#include "map/map.hpp"
#include "map/options.hpp"

namespace polhode {

struct MapInput;  // map/map_state.hpp

/// Should a frame become a keyframe? Yes when the body has rotated against the camera by
/// keyframe_rotation_min_rad since the nearest keyframe (twice that when half of the table is
/// taken, 0.15 of the map's own rotation where that is less). Also when it sees under
/// keyframe_tracked_min of the newest keyframe's landmarks.
bool wants_keyframe(const Map& map, const Pose& pose, int inliers, const MapOptions& options);

/// Stores the frame; its inlier matches become observations. A full table first loses its most
/// redundant keyframe.
/// @return an invalid id when no keyframe may go.
KeyframeId insert_keyframe(const MapInput& frame, const LocalisedFrame& localised, Map* map);

/// Removes the most redundant keyframes until `count` more fit under keyframes_max, or none may go.
/// @return number removed.
int make_room(int count, const MapOptions& options, Map* map);

/// The keyframe with the highest redundancy: the part of its landmarks that three others see. Among
/// equals the one nearest to another keyframe. Never the newest two, nor the only one of its aspect
/// (no other within 20 deg of viewing direction).
KeyframeId most_redundant(const Map& map);

}  // namespace polhode
