// A flat panel in two views: the homography and both of its motions.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "geometry/epipolar.hpp"
#include "solve/relative_pose.hpp"

namespace polhode {

/// Motion and plane n^T p_a = 1 (p_a in units of the plane's distance).
struct PanelMotion {
  RelativePose motion;
  Eigen::Vector3d normal_a = Eigen::Vector3d::UnitZ();  ///< unit length
};

struct HomographyFit {
  Eigen::Matrix3d H_ba = Eigen::Matrix3d::Identity();  ///< x_b ~ H x_a
  double score = 0.0;  ///< truncated sum of squared transfer errors, in sigma
  int inliers = 0;
  FixedVector<PanelMotion, 4>
      motions;  ///< those with the panel in front of both cameras, two as a rule
};

/// Consensus of four-point samples, least squares on the inliers, decomposition.
/// @source Malis and Vargas, INRIA RR-6303, 2007 (decomposition, via OpenCV).
HomographyFit find_homography(std::span<const Eigen::Vector2d> x_a,
                              std::span<const Eigen::Vector2d> x_b,
                              const TwoViewOptions& options);

}  // namespace polhode
