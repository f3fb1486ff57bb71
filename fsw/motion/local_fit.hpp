// Local models of rotation and of path around a reference time, for rates and for prediction.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "base/result.hpp"

namespace polhode {

struct LocalFit {
  Eigen::Vector3d estimate = Eigen::Vector3d::Zero();  ///< at the target
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  ///< of the estimate: noise, unknown bend, misfit
  Eigen::Vector3d at_reference = Eigen::Vector3d::Zero();  ///< fitted value at the reference
  std::size_t points = 0;
  double span_s = 0.0;  ///< largest distance from the reference in time
  double misfit = 1.0;  ///< factor on the declared covariances, >= 1, included in the covariance
  Eigen::Vector3d lever_T =
      Eigen::Vector3d::Zero();  ///< of a path: centre of mass seen from T's origin
};

struct RotationPoint {
  double tau_s = 0.0;                                         ///< time since the reference
  Eigen::Vector3d psi_rad = Eigen::Vector3d::Zero();          ///< R_CT(tau) = R_CT(0) exp(psi)
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< inverse covariance of psi
};

/// What is asked of a fit: at `tau_s` the value (derivative 0) or its rate per second (1).
struct LocalTarget {
  double tau_s = 0.0;
  int derivative = 0;
};

/// Polynomial of degree 6 for psi. What turns at the rate w has derivatives of about A w^k, A being
/// how far the motion is from a constant rate: these are the prior sigmas of the coefficients from
/// the second on; A is averaged over.
/// @param turning_rad_s  rate of the turning, >= 0.
/// @errors TooFewObservations (under 2 points), Degenerate (times coincide, or an information
/// matrix is not usable).
Result<LocalFit> fit_rotation(std::span<const RotationPoint> points,
                              double turning_rad_s,
                              const LocalTarget& target);

struct PathPoint {
  double tau_s = 0.0;
  Eigen::Vector3d p_CT = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_CT = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< inverse covariance of p_CT
};

/// Attitude and rate that belong to the target: they carry T's origin around the centre of mass.
struct PathTarget {
  LocalTarget at;
  Eigen::Matrix3d R_CT = Eigen::Matrix3d::Identity();
  Eigen::Vector3d w_T_rad_s = Eigen::Vector3d::Zero();  ///< used with derivative 1
};

/// T's origin moves as p_CT = g + v tau + a tau^2 / 2 - R_CT c: the centre of mass straight on with
/// at most a slight bend, and the origin around it on the lever c. Sizes of a and c are averaged
/// over, in parts of the range. Attitudes and rate are taken as exact; their share of the
/// covariance is the caller's to add.
/// @param points  the first one is at the reference (tau 0).
/// @errors as fit_rotation().
Result<LocalFit> fit_path(std::span<const PathPoint> points, const PathTarget& target);

}  // namespace polhode
