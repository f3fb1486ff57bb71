#include "motion/published.hpp"

#include <Eigen/Geometry>

namespace polhode {
namespace {

std::array<double, 3> to_array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Of the two quaternions of one rotation the one nearer to the last published.
std::array<double, 4> continuous_quaternion(const Eigen::Matrix3d& R_CT,
                                            std::array<double, 4>* last) {
  Eigen::Quaterniond q(R_CT);
  q.normalize();
  const double dot =
      q.w() * (*last)[0] + q.x() * (*last)[1] + q.y() * (*last)[2] + q.z() * (*last)[3];
  if (dot < 0.0) {
    q.coeffs() *= -1.0;
  }
  *last = {q.w(), q.x(), q.y(), q.z()};
  return *last;
}

}  // namespace

void fill_pose(const Pose& pose,
               const PoseCovariance& covariance,
               std::array<double, 4>* q_last,
               MotionState* m) {
  m->pose_valid = true;
  m->q_CT = continuous_quaternion(pose.R_CT, q_last);
  m->p_CT = to_array(pose.p_CT);
  m->sigma_att_rad = worst_sigma(covariance.topLeftCorner<3, 3>());
  m->sigma_pos = worst_sigma(covariance.bottomRightCorner<3, 3>());
  m->cov_pose = upper_triangle<21>(covariance);
}

void fill_rates(RateEstimate rates, double unit, double length_sigma, MotionState* m) {
  rates.v_C *= unit;
  rates.covariance_v_C = unit * unit * rates.covariance_v_C + by_scale(rates.v_C, length_sigma);
  publish(rates, *m);
  m->cov_w = upper_triangle<6>(rates.covariance_w_T);
  m->cov_v = upper_triangle<6>(rates.covariance_v_C);
}

Pose scaled(const Pose& pose, double unit) { return {.R_CT = pose.R_CT, .p_CT = unit * pose.p_CT}; }

PoseCovariance scaled(const PoseCovariance& covariance, double unit) {
  Eigen::Matrix<double, 6, 1> units;
  units << 1.0, 1.0, 1.0, unit, unit, unit;
  return units.asDiagonal() * covariance * units.asDiagonal();
}

Eigen::Matrix3d by_scale(const Eigen::Vector3d& length, double scale_sigma) {
  return scale_sigma * scale_sigma * length * length.transpose();
}

PoseCovariance by_scale(const Pose& pose, double scale_sigma) {
  PoseCovariance added = PoseCovariance::Zero();
  added.bottomRightCorner<3, 3>() = by_scale(pose.p_CT, scale_sigma);
  return added;
}

}  // namespace polhode
