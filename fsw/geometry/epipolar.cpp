#include "geometry/epipolar.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "geometry/so3.hpp"

namespace polhode {

RelativePose relative_pose(const Pose& a, const Pose& b) {
  const Eigen::Matrix3d R_ba = b.R_CT * a.R_CT.transpose();
  return {.R_ba = R_ba, .p_ba = b.p_CT - R_ba * a.p_CT};
}

Eigen::Matrix3d essential_matrix(const RelativePose& motion) {
  return hat(motion.p_ba) * motion.R_ba;
}

double sampson_error(const Eigen::Matrix3d& E,
                     const Eigen::Vector2d& x_a,
                     const Eigen::Vector2d& x_b) {
  const Eigen::Vector3d line_b = E * x_a.homogeneous();
  const Eigen::Vector3d line_a = E.transpose() * x_b.homogeneous();
  const double gradient2 = line_a.head<2>().squaredNorm() + line_b.head<2>().squaredNorm();
  if (gradient2 <= 0.0) {
    return 0.0;
  }
  return x_b.homogeneous().dot(line_b) / std::sqrt(gradient2);
}

}  // namespace polhode
