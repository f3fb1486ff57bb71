// Pose of the target in the camera: p_C = R_CT * p_T + p_CT.
#pragma once

#include <Eigen/Core>

namespace polhode {

struct Pose {
  Eigen::Matrix3d R_CT = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_CT =
      Eigen::Vector3d::Zero();  ///< map units until the scale is known, then metres

  [[nodiscard]] Eigen::Vector3d to_camera(const Eigen::Vector3d& p_T) const {
    return R_CT * p_T + p_CT;
  }
  /// Camera centre in T.
  [[nodiscard]] Eigen::Vector3d camera_T() const { return -(R_CT.transpose() * p_CT); }
};

/// Is T's origin in front of the camera? A failed estimate may put it behind: such a pose has no
/// inverse depth, and must not be kept.
inline bool is_before_camera(const Pose& pose) {
  return pose.p_CT.allFinite() && pose.p_CT.z() > 0.0;
}

/// Covariance of a pose's error (phi, dp): R_true = exp(phi) R_CT, p_true = p_CT + dp; rad and map
/// units, in C.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

/// Adds an independent error of the attitude, alike about all axes. @param sigma_rad  about each.
inline void widen_attitude(double sigma_rad, PoseCovariance* covariance) {
  covariance->topLeftCorner<3, 3>().diagonal().array() += sigma_rad * sigma_rad;
}

/// Adds an independent error of the position.
/// @param sigma  in each direction, in the pose's unit.
inline void widen_position(double sigma, PoseCovariance* covariance) {
  covariance->bottomRightCorner<3, 3>().diagonal().array() += sigma * sigma;
}

/// The same pose in the axes of another frame X instead of C's.
inline Pose turned(const Eigen::Matrix3d& R_XC, const Pose& pose) {
  return {.R_CT = R_XC * pose.R_CT, .p_CT = R_XC * pose.p_CT};
}

inline PoseCovariance turned(const Eigen::Matrix3d& R_XC, const PoseCovariance& covariance) {
  PoseCovariance by = PoseCovariance::Zero();
  by.topLeftCorner<3, 3>() = R_XC;
  by.bottomRightCorner<3, 3>() = R_XC;
  return by * covariance * by.transpose();
}

}  // namespace polhode
