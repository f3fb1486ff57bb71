// A feature of an image.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"

namespace polhode {

/// RootSIFT (Arandjelovic and Zisserman, CVPR 2012) in bytes: their Euclidean distance is the
/// Hellinger distance of the histograms.
using Descriptor = std::array<std::uint8_t, 128>;

/// Norm of a descriptor. A byte saturates at half of it.
inline constexpr float kDescriptorNorm = 512.0F;

struct Feature {
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();  ///< undistorted image point, plane z = 1
  float u_px = 0.0F;                                     ///< distorted pixel
  float v_px = 0.0F;
  float sigma_px = 1.0F;   ///< 1-sigma of each coordinate
  float scale_px = 1.0F;   ///< radius of the blob
  float angle_rad = 0.0F;  ///< orientation in the image
  Descriptor descriptor{};
};

using Features = FixedVector<Feature, limits::kFeatures>;

}  // namespace polhode
