// Gaussian blur of a float image.
#pragma once

#include <array>

#include "config/limits.hpp"
#include "features/plane.hpp"

namespace polhode::sift {

/// One half of a symmetric kernel whose sum is one.
struct GaussianKernel {
  /// Sigma up to 3.75 px; the largest step of the scale space is 2.3 px.
  static constexpr int kRadiusMax = 12;
  int radius = 0;
  std::array<float, kRadiusMax + 1> weight{};  ///< [0] is the middle
};

/// Cut off at 3.2 sigma: about a thousandth of the weight lies beyond.
/// @pre 0 < sigma_px <= kRadiusMax / 3.2
GaussianKernel gaussian_kernel(double sigma_px);

/// A row between the vertical and the horizontal blur, with a margin on either side.
using BlurRow =
    std::array<float, limits::kWorkingSide + 2 * GaussianKernel::kRadiusMax + 2 * kRowGrain>;

/// Past its border the image is mirrored in the outermost pixels.
/// @param out  of the same size as `in`, at another place.
void blur(const Plane& in, const GaussianKernel& kernel, BlurRow* scratch, const Plane& out);

}  // namespace polhode::sift
