// A map whose memory was hit by bit flips goes on with what is sound of it.
#pragma once

#include <cstdint>

#include "base/repair.hpp"
#include "geometry/camera_model.hpp"
#include "map/map.hpp"

namespace polhode {

/// Nothing happens to a sound map. Of another one, keyframes, landmarks, ties and features that are
/// not sound are dropped, and what follows from the rest is computed anew. Where the counts of
/// slots do not fit, or too little is left to find a pose by, the map is cleared.
/// @cost  is_valid(), and once or twice that for a damaged one.
Repair repair(const CameraModel& camera, std::int64_t now_ns, Map* map);

}  // namespace polhode
