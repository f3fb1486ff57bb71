// Reprojection of a landmark into a frame whose translation is parametrised by inverse depth.
#pragma once

#include <Eigen/Core>

#include "geometry/pose.hpp"

namespace polhode {

/// The pose as bundle adjustment sees it: T's origin has the image (u, v) and the inverse depth s
/// (Christy and Horaud, PAMI 1996). As s * extent goes to 0 the projection becomes weak
/// perspective, so small distant bodies stay well conditioned.
struct InverseDepthPose {
  Eigen::Matrix3d R_CT = Eigen::Matrix3d::Identity();
  Eigen::Vector3d uvs = Eigen::Vector3d(0.0, 0.0, 1.0);  ///< p_x / p_z, p_y / p_z, 1 / p_z
};

InverseDepthPose to_inverse_depth(const Pose& pose);
Pose from_inverse_depth(const InverseDepthPose& pose);

/// Derivative of uvs by the position p_CT.
Eigen::Matrix3d uvs_by_position(const Eigen::Vector3d& p_CT);

/// Normalised image point of p_T: (s r1.p + u, s r2.p + v) / (1 + s r3.p).
/// @return false when the point lies in or behind the camera's plane.
bool reproject(const InverseDepthPose& pose,
               const Eigen::Vector3d& p_T,
               Eigen::Vector2d* normalised);

struct ReprojectionJacobians {
  Eigen::Matrix<double, 2, 3> rotation;  ///< by phi in R = exp(phi) R_CT
  Eigen::Matrix<double, 2, 3> uvs;
  Eigen::Matrix<double, 2, 3> point;  ///< by p_T
};

/// As above, with derivatives.
bool reproject(const InverseDepthPose& pose,
               const Eigen::Vector3d& p_T,
               Eigen::Vector2d* normalised,
               ReprojectionJacobians* jacobians);

/// Derivatives of the projection of p_C = R_CT p_T + p_CT by the pose error (phi, dp) of
/// PoseCovariance. Needs z > 0.
Eigen::Matrix<double, 2, 6> projection_jacobian(const Pose& pose, const Eigen::Vector3d& p_T);

}  // namespace polhode
