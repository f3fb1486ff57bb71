// Writes an adjustment's result into the map, and updates poses and matches that depend on it.
#pragma once

#include "map/map_state.hpp"
#include "map/window.hpp"

namespace polhode {

/// The change by an adjustment's result.
struct MapUpdate {
  MapCorrection correction;
  bool applied = false;
};

/// Writes an adjustment's result into the map. A loop closure fixes the drift at both ends.
MapUpdate take_adjusted(const AdjustmentSnapshot& snapshot,
                        bool usable,
                        bool closed,
                        MapState* state);

/// Does the map still contain keyframes from before the last re-anchoring?
[[nodiscard]] bool reaches_over_reanchoring(const MapState& state);

/// Moves a flow reference that is newer than the adjusted keyframes along with them.
void correct_reference(const MapCorrection& correction, MapState* state);

/// Copies a moved keyframe's pose to the flow reference and to this frame, where they are of the
/// same image.
/// @param frame  this one. @return whether this frame is the keyframe.
bool follow_keyframe(const Keyframe& keyframe, std::uint32_t frame, MapState* state);

/// Updates landmarks and matches after a change of the map.
void refresh_map(const CameraModel& camera, MapState* state);

/// Solves again, from the keyframe's observations, for the pose of this frame or of the earlier one
/// that became the keyframe. Result and matches are in `localised`.
bool pose_from_keyframe(const Keyframe& keyframe, const MapInput& input, MapState* state);

}  // namespace polhode
