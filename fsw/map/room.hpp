// What a full table of landmarks gives up for a side that comes into view.
#pragma once

#include <cstddef>

#include "map/map.hpp"

namespace polhode {

/// Frees slots until `wanted` are free: of the landmarks that none of the newest two keyframes
/// sees, those go first that fewest keyframes confirm, and among equals those that were not seen
/// for longest. What the newest keyframes see stays, so tracking goes on.
/// @return landmarks that went.
int make_landmark_room(std::size_t wanted, Map* map);

}  // namespace polhode
