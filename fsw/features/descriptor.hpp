// SIFT descriptor of a blob's neighbourhood.
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

/// Histograms of the gradients' directions, 8 bins, in 4 x 4 fields of 3 sigma, rotated with the
/// place.
/// @source Lowe, IJCV 2004, section 6.1; sampled on a grid of the place's own size instead of pixel
/// by pixel.
Descriptor compute_descriptor(const Plane& level, const OrientedPlace& place);

}  // namespace polhode::sift
