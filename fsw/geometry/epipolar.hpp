// Two views of one rigid body: essential matrix and Sampson error.
#pragma once

#include <Eigen/Core>

#include "geometry/pose.hpp"

namespace polhode {

/// Motion between two views a and b of points given in a: p_b = R_ba p_a + p_ba.
struct RelativePose {
  Eigen::Matrix3d R_ba = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_ba =
      Eigen::Vector3d::Zero();  ///< known up to scale when it comes from two views
};

RelativePose relative_pose(const Pose& a, const Pose& b);

/// E with x_b^T E x_a = 0.
Eigen::Matrix3d essential_matrix(const RelativePose& motion);

/// First-order distance of a pair of normalised image points from the epipolar constraint, signed,
/// in normalised units.
double sampson_error(const Eigen::Matrix3d& E,
                     const Eigen::Vector2d& x_a,
                     const Eigen::Vector2d& x_b);

}  // namespace polhode
