// Makes a map, or a further part of one, from the selected hypothesis.
#pragma once

#include "geometry/alignment.hpp"
#include "initialisation/initialise.hpp"
#include "map/map.hpp"
#include "map/options.hpp"
#include "tracks/track_table.hpp"

namespace polhode {

/// Each frame with a pose becomes a keyframe, each track with a point a landmark observed by its
/// features. Present entries of the map stay; full tables take no more.
/// @param first_frame  of the initialisation, in the table.
/// @param to_T  takes the initialisation's frame and unit to the map's.
void begin_map(const InitialOutcome& outcome,
               std::size_t first_frame,
               const TrackTable& tracks,
               const Similarity& to_T,
               const MapOptions& options,
               Map* map);

}  // namespace polhode
