// Keyframe insertion and the growth of the map.
#pragma once

#include "map/map_state.hpp"
#include "mask/mask_state.hpp"

namespace polhode {

/// Result of a keyframe's insertion.
struct Growth {
  KeyframeId keyframe;      ///< invalid: there was no room
  bool loop_found = false;  ///< loop closure: an adjustment of all keyframes is due
};

/// Should this frame become a keyframe?
[[nodiscard]] bool wants_keyframe(const MapInput& input, const MapState& state);

/// Removes the frame's features that the sharpened outline rules out, so that they make no
/// landmarks. Features matched to a landmark stay; the indices of matches are updated.
void veto_features(const MaskState& mask, Features* features, LandmarkMatches* matches);

/// Makes this frame, with its pose, a keyframe; triangulates new landmarks; searches for a loop
/// closure.
Growth grow_map(const MapInput& input, MapState* state);

/// Adds the landmarks that keyframes from this number on give beyond those of the initialisation.
void complete_map(std::uint32_t first_keyframe, const MapInput& input, MapState* state);

/// Drops observations and landmarks that do not fit.
void cull_misfits(const CameraModel& camera, MapState* state);

/// Drops the matches of culled landmarks: their slots may have other landmarks by now.
void keep_matches_of_map(const Map& map, LandmarkMatches* matches);

}  // namespace polhode
