// Local models of rotation and translation around a reference time, for rates and prediction.
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
  Eigen::Vector3d mass_centre_offset_T =
      Eigen::Vector3d::Zero();  ///< of fit_translation(): centre of mass relative to T's origin
};

struct RotationPoint {
  double tau_s = 0.0;                                         ///< time since the reference
  Eigen::Vector3d psi_rad = Eigen::Vector3d::Zero();          ///< R_CT(tau) = R_CT(0) exp(psi)
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< inverse covariance of psi
};

/// What a fit is to give: at `tau_s` the value (derivative 0) or its rate per second (1).
struct LocalTarget {
  double tau_s = 0.0;
  int derivative = 0;
};

/// Polynomial of degree 6 for psi. Rotation at the rate w has derivatives of about A w^k, with A
/// the deviation from a constant rate. These are the prior sigmas of the coefficients from the
/// second on. A is averaged over.
/// @param rotation_rad_s  rotation rate, >= 0.
/// @errors TooFewObservations (under 2 points), Degenerate (times coincide, or an information
/// matrix is not usable).
Result<LocalFit> fit_rotation(std::span<const RotationPoint> points,
                              double rotation_rad_s,
                              const LocalTarget& target);

struct TranslationPoint {
  double tau_s = 0.0;
  Eigen::Vector3d p_CT = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_CT = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< inverse covariance of p_CT
};

/// Attitude and rate at the target time: they move T's origin around the centre of mass.
struct TranslationTarget {
  LocalTarget at;
  Eigen::Matrix3d R_CT = Eigen::Matrix3d::Identity();
  Eigen::Vector3d w_T_rad_s = Eigen::Vector3d::Zero();  ///< used with derivative 1
};

/// T's origin moves as p_CT = g + v tau + a tau^2 / 2 - R_CT c. The centre of mass moves on a
/// straight line with at most a slight bend, and the origin around it at the offset c. Sizes of a
/// and c are averaged over, in parts of the range. Attitudes and rate are taken as exact: the
/// caller adds their share of the covariance.
/// @param points  the first one is at the reference (tau 0).
/// @errors as fit_rotation().
Result<LocalFit> fit_translation(std::span<const TranslationPoint> points,
                                 const TranslationTarget& target);

}  // namespace polhode
