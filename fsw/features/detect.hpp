// Features: sub-pixel blobs with rotation-invariant descriptors, spread over the target.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "features/options.hpp"
#include "geometry/camera_model.hpp"
#include "mask/target_mask.hpp"

namespace polhode {

/// RootSIFT (Arandjelovic and Zisserman, CVPR 2012) in octets: Euclidean distance compares
/// histograms by Hellinger's.
using Descriptor = std::array<std::uint8_t, 128>;

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

/// Detects in the mask's region, resampled to the working size (at most twice its own), and keeps
/// at most count_max by strength with an even share for each cell of a grid over the region.
/// @source Lowe, IJCV 2004, by way of OpenCV.
void detect_features(const cv::Mat& gray,
                     const TargetMask& mask,
                     const CameraModel& camera,
                     const FeatureOptions& options,
                     Features* features);

}  // namespace polhode
