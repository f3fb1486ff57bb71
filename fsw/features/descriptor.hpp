// What a blob's neighbourhood looks like.
#pragma once

#include "features/feature.hpp"
#include "features/plane.hpp"

namespace polhode::sift {

struct OrientedPlace {
  float x = 0.0F;  ///< pixels of the level
  float y = 0.0F;
  float sigma_px = 1.0F;
  float angle_rad = 0.0F;
};

/// Histograms of the gradients' directions, 8 bins, in 4 x 4 fields of 3 sigma, turned with the
/// place.
/// @source Lowe, IJCV 2004, section 6.1; sampled on a grid of the place's own size instead of pixel
/// by pixel.
Descriptor describe(const Plane& level, const OrientedPlace& place);

}  // namespace polhode::sift
