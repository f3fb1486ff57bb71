#include "motion/paper.hpp"

#include <Eigen/LU>
#include <cmath>

#include "geometry/so3.hpp"

namespace polhode {

Result<PaperRate> paper_rate(const PoseSample& first, const PoseSample& second) {
  const double interval_s = seconds_between(first.timestamp_ns, second.timestamp_ns);
  if (!(interval_s > 0.0)) {
    return ErrorCode::kDegenerate;
  }
  PaperRate rate;
  rate.timestamp_ns = first.timestamp_ns + (second.timestamp_ns - first.timestamp_ns) / 2;
  rate.interval_s = interval_s;
  const Eigen::Vector3d psi_rad = so3_log(first.pose.R_CT.transpose() * second.pose.R_CT);
  rate.w_T_rad_s = psi_rad / interval_s;
  // exp(phi2) R2 and exp(phi1) R1: phi2 - phi1, rotated into T, appears through the inverse left
  // Jacobian of psi.
  const Eigen::Matrix3d to_psi =
      so3_left_jacobian(psi_rad).inverse() * first.pose.R_CT.transpose() / interval_s;
  rate.covariance_w_T =
      to_psi * (first.covariance.topLeftCorner<3, 3>() + second.covariance.topLeftCorner<3, 3>()) *
      to_psi.transpose();
  rate.v_C = (second.pose.p_CT - first.pose.p_CT) / interval_s;
  rate.radial_speed = (second.pose.p_CT.norm() - first.pose.p_CT.norm()) / interval_s;
  const Eigen::Vector3d e1 = first.pose.p_CT.normalized();
  const Eigen::Vector3d e2 = second.pose.p_CT.normalized();
  rate.sigma_radial = std::sqrt(e1.dot(first.covariance.bottomRightCorner<3, 3>() * e1) +
                                e2.dot(second.covariance.bottomRightCorner<3, 3>() * e2)) /
                      interval_s;
  return rate;
}

}  // namespace polhode
