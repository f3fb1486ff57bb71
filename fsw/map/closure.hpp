// Loop closure on a revisited aspect: associates its old landmarks with the newest keyframe.
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

/// Searches the newest keyframe's features for landmarks that were last seen long ago, within a
/// third of the body of their projections. When enough of them agree on one pose near the
/// keyframe's, each is associated with its feature; a younger landmark of that feature is merged
/// into it. The drift stays in the map until an adjustment of all keyframes, which has to follow.
/// @param input  of the keyframe's frame; its age is set here.
/// @return observations associated or landmarks merged; 0 when no aspect is revisited.
int close_loop(LocaliseInput input,
               KeyframeId keyframe,
               const ClosureOptions& options,
               MapScratch* scratch,
               Map* map);

}  // namespace polhode
