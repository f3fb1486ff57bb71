#include "geometry/reprojection.hpp"

#include "base/assert.hpp"

namespace polhode {
InverseDepthPose to_inverse_depth(const Pose& pose) {
  POLHODE_ASSERT(is_before_camera(pose), pose.p_CT.z());
  const double s = 1.0 / pose.p_CT.z();
  return {.R_CT = pose.R_CT, .uvs = {pose.p_CT.x() * s, pose.p_CT.y() * s, s}};
}

Pose from_inverse_depth(const InverseDepthPose& pose) {
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

}  // namespace polhode
