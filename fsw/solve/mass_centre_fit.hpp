// Translation of the mass centre and its offset in the body, from positions of the body's origin:
// linear least squares. Attitudes are known from the fit of the rotation.
#pragma once

#include <cstddef>
#include <span>

#include "base/result.hpp"
#include "solve/rigid_body.hpp"

namespace polhode {

/// Unknowns of the translation: mass centre p and velocity v at the reference in I, relative to the
/// observer; centre-of-mass offset c from T's origin, in T.
inline constexpr int kTranslationUnknowns = 9;
using TranslationVector = Eigen::Matrix<double, kTranslationUnknowns, 1>;
using TranslationCovariance = Eigen::Matrix<double, kTranslationUnknowns, kTranslationUnknowns>;

struct PositionSample {
  double time_s = 0.0;
  Eigen::Vector3d p_I = Eigen::Vector3d::Zero();  ///< T's origin relative to the observer
  Eigen::Matrix3d information_I = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d R_IT = Eigen::Matrix3d::Identity();  ///< by the fit of the rotation
  RotationJacobian attitude_by_rotation_I = RotationJacobian::Zero();
};

struct TranslationProblem {
  std::span<const PositionSample> samples;
  double reference_s = 0.0;
  Orbit orbit;
  Eigen::Vector3d mass_centre_T = Eigen::Vector3d::Zero();  ///< prior
  Eigen::Vector3d mass_centre_sigma =
      Eigen::Vector3d::Ones();  ///< half the body's size, if unknown
  double cauchy_sigma = kPoseCauchySigma;
};

struct TranslationSolution {
  TranslationVector unknowns = TranslationVector::Zero();
  TranslationCovariance information =
      TranslationCovariance::Zero();  ///< by the declared noise, with the prior
  /// Derivatives of the unknowns by those of the rotation: propagates its errors.
  Eigen::Matrix<double, kTranslationUnknowns, kRotationUnknowns> by_rotation =
      Eigen::Matrix<double, kTranslationUnknowns, kRotationUnknowns>::Zero();
};

/// Position and velocity (p, v) `interval_s` later as a linear function of those at `time_s`: in a
/// straight line, or by Hill's equations about an observer in orbit. Axes I.
Eigen::Matrix<double, 6, 6> translation_transition(const Orbit& orbit,
                                                   double time_s,
                                                   double interval_s);

/// @errors TooFewObservations (under 4 samples), Degenerate (no time passes, or a covariance is not
/// usable), BadParameter (a mass_centre_sigma not positive).
/// @cost   four rounds over the samples.
Result<TranslationSolution> solve_translation(const TranslationProblem& problem);

}  // namespace polhode
