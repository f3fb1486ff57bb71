#include "geometry/reprojection.hpp"

#include "base/assert.hpp"
#include "geometry/so3.hpp"

namespace polhode {
InverseDepthPose to_inverse_depth(const Pose& pose) {
  POLHODE_ASSERT(pose.p_CT.z() > 0.0, pose.p_CT.z());
  const double s = 1.0 / pose.p_CT.z();
  return {.R_CT = pose.R_CT, .uvs = {pose.p_CT.x() * s, pose.p_CT.y() * s, s}};
}

Pose from_inverse_depth(const InverseDepthPose& pose) {
  POLHODE_ASSERT(pose.uvs.z() > 0.0, pose.uvs.z());
  const double depth = 1.0 / pose.uvs.z();
  return {.R_CT = pose.R_CT, .p_CT = {pose.uvs.x() * depth, pose.uvs.y() * depth, depth}};
}

Eigen::Matrix3d uvs_by_position(const Eigen::Vector3d& p_CT) {
  const double s = 1.0 / p_CT.z();
  Eigen::Matrix3d by;
  by << s, 0.0, -p_CT.x() * s * s,  //
      0.0, s, -p_CT.y() * s * s,    //
      0.0, 0.0, -s * s;
  return by;
}

Eigen::Matrix<double, 2, 6> projection_jacobian(const Pose& pose, const Eigen::Vector3d& p_T) {
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
