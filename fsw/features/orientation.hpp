// Which way a blob's neighbourhood points.
#pragma once

#include "base/fixed_vector.hpp"
#include "features/plane.hpp"

namespace polhode::sift {

using Orientations = FixedVector<float, 4>;

/// Directions of the strongest gradients about a place, radians in 0 .. 2 pi, from u towards v;
/// those within 80 % of the strongest, in the order of their angle.
/// @param x, y, sigma_px  pixels of the level.
/// @source Lowe, IJCV 2004, section 5.
void find_orientations(const Plane& level, float x, float y, float sigma_px, Orientations* out);

}  // namespace polhode::sift
