// Repair of a map whose memory was hit by bit flips: its valid parts are kept.
#pragma once

#include <cstdint>

#include "base/repair.hpp"
#include "geometry/camera_model.hpp"
#include "map/map.hpp"

namespace polhode {

/// Leaves a valid map unchanged. Otherwise drops invalid keyframes, landmarks, associations and
/// features, and computes the derived values again. Clears the map where the counts of slots do not
/// fit, or too little is left for a pose.
/// @cost  is_valid(), and once or twice that for a damaged one.
Repair repair(const CameraModel& camera, std::int64_t now_ns, Map* map);

}  // namespace polhode
