// Reprojection of a landmark into a frame whose translation is parametrised by inverse depth.
#pragma once

#include <Eigen/Core>

#include "geometry/pose.hpp"
#include "geometry/so3.hpp"

namespace polhode {

/// The pose as bundle adjustment uses it: T's origin has the image (u, v) and the inverse depth s
/// (Christy and Horaud, PAMI 1996). As s * extent goes to 0 the projection becomes weak
/// perspective, so small distant bodies stay well conditioned.
struct InverseDepthPose {
  Eigen::Matrix3d R_CT = Eigen::Matrix3d::Identity();
  Eigen::Vector3d uvs = Eigen::Vector3d(0.0, 0.0, 1.0);  ///< p_x / p_z, p_y / p_z, 1 / p_z
};

/// @pre is_before_camera(pose)
InverseDepthPose to_inverse_depth(const Pose& pose);
/// @return a pose that is_before_camera() where s > 0. An adjustment that went wrong leaves another
/// s.
Pose from_inverse_depth(const InverseDepthPose& pose);

/// Derivative of uvs by the position p_CT.
Eigen::Matrix3d uvs_by_position(const Eigen::Vector3d& p_CT);

struct ReprojectionJacobians {
  Eigen::Matrix<double, 2, 3> rotation;  ///< by phi in R = exp(phi) R_CT
  Eigen::Matrix<double, 2, 3> uvs;
  Eigen::Matrix<double, 2, 3> point;  ///< by p_T
};

/// Normalised image point of p_T: (s r1.p + u, s r2.p + v) / (1 + s r3.p), and its derivatives.
/// Inline and written out: adjustments spend most of their time here.
/// @param jacobians  may be nullptr
/// @return false when the point lies in or behind the camera's plane.
inline bool reproject(const InverseDepthPose& pose,
                      const Eigen::Vector3d& p_T,
                      Eigen::Vector2d* normalised,
                      ReprojectionJacobians* jacobians = nullptr) {
  // Depth over the origin's, under which a point counts as in the camera's plane. Chosen: larger
  // rejects points of a body close by, smaller lets the division lose digits.
  constexpr double kRelativeDepthMin = 1e-3;
  const Eigen::Vector3d q = pose.R_CT * p_T;
  const double s = pose.uvs.z();
  const double denominator = 1.0 + s * q.z();
  if (!(denominator > kRelativeDepthMin) || !(s > 0.0)) {
    return false;
  }
  const double inverse = 1.0 / denominator;
  const double x = (s * q.x() + pose.uvs.x()) * inverse;
  const double y = (s * q.y() + pose.uvs.y()) * inverse;
  *normalised = {x, y};
  if (jacobians == nullptr) {
    return true;
  }
  // By q = R p: (a, 0, -a x) and (0, a, -a y); a rotation by phi moves q by phi x q.
  const double a = s * inverse;
  jacobians->rotation << -a * x * q.y(), a * (x * q.x() + q.z()), -a * q.y(),  //
      -a * (y * q.y() + q.z()), a * y * q.x(), a * q.x();
  jacobians->uvs << inverse, 0.0, inverse * (q.x() - x * q.z()),  //
      0.0, inverse, inverse * (q.y() - y * q.z());
  jacobians->point.row(0) = a * (pose.R_CT.row(0) - x * pose.R_CT.row(2));
  jacobians->point.row(1) = a * (pose.R_CT.row(1) - y * pose.R_CT.row(2));
  return true;
}

/// Derivatives of the projection of p_C = R_CT p_T + p_CT by the pose error (phi, dp) of
/// PoseCovariance. Needs z > 0.
inline Eigen::Matrix<double, 2, 6> projection_jacobian(const Pose& pose,
                                                       const Eigen::Vector3d& p_T) {
  const Eigen::Vector3d q = pose.R_CT * p_T;
  const Eigen::Vector3d p_C = q + pose.p_CT;
  const double inverse = 1.0 / p_C.z();
  Eigen::Matrix<double, 2, 3> by_p;
  by_p << inverse, 0.0, -inverse * inverse * p_C.x(), 0.0, inverse, -inverse * inverse * p_C.y();
  Eigen::Matrix<double, 2, 6> J;
  J << -by_p * hat(q), by_p;
  return J;
}

}  // namespace polhode
