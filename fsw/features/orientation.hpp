// Orientations of a blob's neighbourhood.
#pragma once

#include "base/fixed_vector.hpp"
#include "features/plane.hpp"

namespace polhode::sift {

/// Lowe finds more than one at 15 % of the places; a fifth one is dropped.
using Orientations = FixedVector<float, 4>;

/// Peaks of the histogram of gradient directions around a place: those of at least 80 % of the
/// highest, in the order of their angle. Radians in 0 .. 2 pi, from u towards v.
/// @param x, y, sigma_px  pixels of the level.
/// @source Lowe, IJCV 2004, section 5.
void find_orientations(const Plane& level, float x, float y, float sigma_px, Orientations* out);

}  // namespace polhode::sift
