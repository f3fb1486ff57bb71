// A side comes back: its old landmarks and the newest keyframe are tied together.
#pragma once

#include "map/localise.hpp"
#include "map/map.hpp"

namespace polhode {

struct MapScratch;  // map/map_state.hpp

struct ClosureOptions {
  int inliers_min = kInliersAlone;
  double inlier_fraction_min =
      0.3;  ///< of the matches; in a circle of tens of pixels none agree by chance
  double turn_max_rad = 0.35;  ///< 20 deg of drift: a four-sided body looks alike at 90 deg
};

/// Looks for landmarks that were last seen long ago among the newest keyframe's features, within a
/// third of the body about where the keyframe's pose puts them. When enough of them agree on one
/// pose near the keyframe's, each becomes the landmark of its feature; a younger landmark that
/// stood there is merged into it. The drift is still in the map then: an adjustment of all
/// keyframes has to follow.
/// @param input  of the keyframe's frame; its age is set here.
/// @return observations tied or landmarks merged; 0 when nothing has come back.
int close_loop(LocaliseInput input,
               KeyframeId keyframe,
               const ClosureOptions& options,
               MapScratch* scratch,
               Map* map);

}  // namespace polhode
