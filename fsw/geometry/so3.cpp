#include "geometry/so3.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace polhode {
namespace {
// Below this angle two terms of the series are exact to rounding: the third is under 1e-16. The
// closed forms lose digits there.
constexpr double kSmallAngle_rad = 1e-4;
// Of half the angle. Below it atan2(sine, w) / sine is 1 to rounding; avoids 0 / 0.
constexpr double kSmallSine = 1e-12;
}  // namespace

Eigen::Matrix3d hat(const Eigen::Vector3d& a) {
  Eigen::Matrix3d A;
  A << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return A;
}

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& phi_rad) {
  const double angle2 = phi_rad.squaredNorm();
  const double angle = std::sqrt(angle2);
  const Eigen::Matrix3d K = hat(phi_rad);
  double a = 1.0 - angle2 / 6.0;
  double b = 0.5 - angle2 / 24.0;
  if (angle > kSmallAngle_rad) {
    a = std::sin(angle) / angle;
    const double half = std::sin(0.5 * angle);
    b = 2.0 * half * half / angle2;
  }
  return Eigen::Matrix3d::Identity() + a * K + b * K * K;
}

Eigen::Vector3d so3_log(const Eigen::Matrix3d& R) {
  // Via the quaternion: well conditioned at 0 and at pi.
  Eigen::Quaterniond q(R);
  if (q.w() < 0.0) {
    q.coeffs() *= -1.0;
  }
  const double sine = q.vec().norm();
  if (sine < kSmallSine) {
    return 2.0 * q.vec();
  }
  return 2.0 * std::atan2(sine, q.w()) / sine * q.vec();
}

Eigen::Matrix3d so3_left_jacobian(const Eigen::Vector3d& phi_rad) {
  const double angle2 = phi_rad.squaredNorm();
  const double angle = std::sqrt(angle2);
  const Eigen::Matrix3d K = hat(phi_rad);
  double a = 0.5 - angle2 / 24.0;
  double b = 1.0 / 6.0 - angle2 / 120.0;
  if (angle > kSmallAngle_rad) {
    const double half = std::sin(0.5 * angle);
    a = 2.0 * half * half / angle2;
    b = (angle - std::sin(angle)) / (angle2 * angle);
  }
  return Eigen::Matrix3d::Identity() + a * K + b * K * K;
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
}

double rotation_angle_rad(const Eigen::Matrix3d& R_a, const Eigen::Matrix3d& R_b) {
  return so3_log(R_a.transpose() * R_b).norm();
}

}  // namespace polhode
