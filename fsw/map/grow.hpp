// A frame becomes a keyframe, and the map grows by what it sees.
#pragma once

#include "map/map_state.hpp"
#include "mask/mask_state.hpp"

namespace polhode {

/// What a keyframe has brought.
struct Growth {
  KeyframeId keyframe;      ///< invalid: there was no room
  bool loop_found = false;  ///< loop closure: an adjustment of all keyframes is due
};

/// Should this frame become a keyframe?
[[nodiscard]] bool wants_keyframe(const MapInput& input, const MapState& state);

/// Takes features that the sharpened outline rules out of the frame: they make no landmarks. What
/// is matched to a landmark stays; the matches follow their features.
void veto_features(const MaskState& mask, Features* features, LandmarkMatches* matches);

/// Makes this frame, with its pose, a keyframe; triangulates new landmarks; looks for a loop.
Growth grow_map(const MapInput& input, MapState* state);

/// The landmarks that keyframes with this number and later ones give beyond those of the
/// initialisation.
void complete_map(std::uint32_t first_keyframe, const MapInput& input, MapState* state);

/// Observations and landmarks that do not fit go.
void cull_misfits(const CameraModel& camera, MapState* state);

/// The matches whose landmarks are still there: culled ones' places are taken by others.
void keep_matches_of_map(const Map& map, LandmarkMatches* matches);

}  // namespace polhode
