// The first map, from a contest that was won.
#pragma once

#include "map/initialise.hpp"
#include "map/map.hpp"
#include "map/options.hpp"
#include "tracks/track_table.hpp"

namespace polhode {

/// Each frame with a pose becomes a keyframe, each track with a point a landmark seen where its
/// features are.
void begin_map(const StartOutcome& outcome,
               const TrackTable& tracks,
               const MapOptions& options,
               Map* map);

}  // namespace polhode
