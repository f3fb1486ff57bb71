// The paper's motion parameters: rates and speeds from pairs of poses, and a sine through each
// component of the rate.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "base/fixed_vector.hpp"
#include "base/result.hpp"
#include "motion/pose_history.hpp"
#include "solve/sine_fit.hpp"

namespace polhode {

/// Rate and speed from two successive poses. They hold for the middle of the interval. At either
/// end their error is the change of the rate over half of it.
struct PaperRate {
  std::int64_t timestamp_ns = 0;  ///< of the middle
  double interval_s = 0.0;
  Eigen::Vector3d w_T_rad_s =
      Eigen::Vector3d::Zero();  ///< rotation vector of R_CT(t)^T R_CT(t + dt), over dt
  Eigen::Matrix3d covariance_w_T = Eigen::Matrix3d::Zero();
  double radial_speed =
      0.0;  ///< change of the radius vector's length, over dt; positive when it grows
  double sigma_radial = 0.0;
  Eigen::Vector3d v_C = Eigen::Vector3d::Zero();  ///< change of the radius vector, over dt
};

/// Eqs. (1)-(4) for one pair. @errors Degenerate (times not increasing).
Result<PaperRate> paper_rate(const PoseSample& first, const PoseSample& second);

/// Poses of a run that paper mode can keep. Chosen: 33 minutes at 10 Hz.
inline constexpr std::size_t kSineSamplesMax = 20000;

/// Straight motion of the centre of mass and its place in the body: p_CT(t) = p0 + v t - R_CT(t) c.
struct DriftFit {
  Eigen::Vector3d p0_C = Eigen::Vector3d::Zero();  ///< centre of mass at the first pose
  Eigen::Vector3d v_C = Eigen::Vector3d::Zero();   ///< its velocity
  Eigen::Vector3d c_T = Eigen::Vector3d::Zero();   ///< it, seen from T's origin
  Eigen::Matrix3d covariance_v_C = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d covariance_c_T = Eigen::Matrix3d::Zero();
  double chi2_per_dof = 0.0;
  double speed = 0.0;
};

/// Linear least squares with the prior that the centre of mass lies within the body: c has the
/// prior sigma `body_radius` in each direction. A direction in which the covariance stays near that
/// is not observed, as the spin axis of a pure spin. Covariances are scaled up where the residuals
/// are larger than declared.
/// @errors TooFewObservations (under 4 poses), Degenerate (no time passes, covariance not usable),
/// BadParameter
///         (body_radius not positive).
Result<DriftFit> fit_drift(std::span<const PoseSample> poses, double body_radius);

}  // namespace polhode
