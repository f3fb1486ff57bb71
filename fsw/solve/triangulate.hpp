// Triangulates a point of the body from its observations in several frames of known pose.
#pragma once

#include <Eigen/Core>
#include <span>

#include "base/result.hpp"
#include "geometry/pose.hpp"

namespace polhode {

struct RayObservation {
  Pose pose;
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();
  double sigma_normalised = 1.0;  ///< 1-sigma of each coordinate
};

struct TriangulatedPoint {
  Eigen::Vector3d p_T = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_T = Eigen::Matrix3d::Zero();  ///< poses taken as exact
  double chi2 = 0.0;                                       ///< with 2 N - 3 degrees of freedom
  double parallax_rad = 0.0;                               ///< largest angle between two rays
};

/// Linear solution, then at most five steps on the reprojection error.
/// @errors TooFewObservations (under 2), Degenerate (rays parallel, or the point behind a camera).
Result<TriangulatedPoint> triangulate(std::span<const RayObservation> observations);

}  // namespace polhode
