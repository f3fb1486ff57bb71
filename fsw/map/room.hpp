// Frees slots of a full table of landmarks for an aspect that comes into view.
#pragma once

#include <cstddef>

#include "map/map.hpp"

namespace polhode {

/// Frees slots until `wanted` are free. Landmarks seen by the newest two keyframes stay, so
/// tracking goes on. Of the others those with fewest observations go first, and among equals those
/// unseen for longest.
/// @return landmarks removed.
int make_landmark_room(std::size_t wanted, Map* map);

}  // namespace polhode
