// Gaussian blur of a float picture.
#pragma once

#include <array>

#include "config/limits.hpp"
#include "features/plane.hpp"

namespace polhode::sift {

/// One half of a symmetric kernel whose sum is one.
struct GaussianKernel {
  static constexpr int kRadiusMax = 12;
  int radius = 0;
  std::array<float, kRadiusMax + 1> weight{};  ///< [0] is the middle
};

/// Cut at 3.2 sigma, where a thousandth of the weight is left.
/// @pre 0 < sigma_px <= kRadiusMax / 3.2
GaussianKernel gaussian_kernel(double sigma_px);

/// A row on its way through the blur, with a margin on either side.
using BlurRow =
    std::array<float, limits::kWorkingSide + 2 * GaussianKernel::kRadiusMax + 2 * kRowGrain>;

/// The picture goes on past its border as in a mirror that stands in the outermost pixels.
/// @param out  of the same size as `in`, at another place.
void blur(const Plane& in, const GaussianKernel& kernel, BlurRow* scratch, const Plane& out);

}  // namespace polhode::sift
