// Makes a map, or a further part of one, from the selected hypothesis.
#pragma once

#include "geometry/alignment.hpp"
#include "initialisation/initialise.hpp"
#include "map/map.hpp"
#include "map/options.hpp"
#include "tracks/track_table.hpp"

namespace polhode {

/// What is taken over of an initialisation. Pointers are never null.
struct InitialMap {
  const InitialOutcome* outcome = nullptr;
  std::size_t first_frame = 0;  ///< the initialisation's, in the table
  const TrackTable* tracks = nullptr;
  Similarity to_T = {};  ///< takes the initialisation's frame and unit to the map's
};

/// Each frame with a pose becomes a keyframe, each track with a point a landmark observed by its
/// features. Present entries of the map stay; full tables take no more.
void begin_map(const InitialMap& initial, const MapOptions& options, Map* map);

}  // namespace polhode
