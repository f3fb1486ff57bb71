// Attitude, rate and inertia of a rigid body from attitudes over time: nonlinear least squares
// under Euler's equation.
#pragma once

#include <cstddef>
#include <span>

#include "base/result.hpp"
#include "solve/rigid_body.hpp"

namespace polhode {

struct AttitudeSample {
  double time_s = 0.0;
  Eigen::Matrix3d R_IT = Eigen::Matrix3d::Identity();
  /// Inverse covariance of phi in I, R_true = exp(phi) R_IT, by the declared noise.
  Eigen::Matrix3d information_I = Eigen::Matrix3d::Identity();
};

struct RotationProblem {
  std::span<const AttitudeSample> samples;  ///< in order of time
  std::size_t reference = 0;                ///< sample at whose time the unknowns are
  Orbit orbit;                              ///< same epoch as the samples
  ShapePrior prior = {};
  double cauchy_sigma = kPoseCauchySigma;
  int iterations_max = 12;  ///< a bound: it ends when chi-square has settled
};

struct RotationSolution {
  RotationState reference;
  InertiaShape shape = InertiaShape::Zero();
  /// Inverse covariance of the unknowns by the declared noise, outliers weighted down, with the
  /// prior of the shape.
  RotationCovariance information = RotationCovariance::Zero();
  double cost = 0.0;  ///< sum of log(1 + chi2 of a sample): compares solutions of the same samples
  double median2 = 0.0;  ///< median chi2 of a sample over that of normal noise
  double chi2 = 0.0;     ///< of the samples within the gate
  std::size_t inside =
      0;  ///< samples within the gate: 5 sigma of the larger of declared and found noise
  int iterations = 0;
};

/// Robust fit from `start` (its reference state at the reference sample's time) over
/// samples [first, last).
/// @errors Degenerate: it diverges, or a covariance is not usable.
/// @cost   problem.iterations_max integrations over the samples.
Result<RotationSolution> refine_rotation(const RotationProblem& problem,
                                         const RotationSolution& start,
                                         std::size_t first,
                                         std::size_t last);

/// Without a prior solution. Constant angular momentum is linear in the inertia, which gives a
/// first shape; the window around the reference doubles as far as the solution predicts. Where that
/// does not reach `chi2_per_dof_max`, ball, rod and disc about the mean axis are tried too and the
/// best one is taken.
/// @errors TooFewObservations (under 4 samples), Degenerate (all diverge).
Result<RotationSolution> solve_rotation(const RotationProblem& problem, double chi2_per_dof_max);

/// chi2 over its degrees of freedom, of the samples within the gate.
[[nodiscard]] double chi2_per_dof(const RotationSolution& solution);

}  // namespace polhode
