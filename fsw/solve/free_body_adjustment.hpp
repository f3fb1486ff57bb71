// Joint adjustment of points and of a free body's motion to their images: the poses are those of
// one torque-free (or orbiting) rigid body, whatever their number.
//
// Free poses drift, because each is placed by the landmarks of the last few. A body's motion has
// twenty unknowns, and nothing in them drifts.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "solve/bundle_problem.hpp"
#include "solve/mass_centre_fit.hpp"
#include "solve/rigid_body.hpp"

namespace polhode {

/// Those of the rotation, then those of the translation.
inline constexpr int kFreeBodyUnknowns = kRotationUnknowns + kTranslationUnknowns;
using FreeBodyVector = Eigen::Matrix<double, kFreeBodyUnknowns, 1>;
using FreeBodyInformation = Eigen::Matrix<double, kFreeBodyUnknowns, kFreeBodyUnknowns>;

/// Time of a pose, and the observer's attitude then.
struct PoseTime {
  double time_s = 0.0;  ///< same epoch as the motion's reference and the orbit
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();
};

struct FreeBodyMotion {
  RotationState reference;
  InertiaShape shape = InertiaShape::Zero();
  TranslationVector path = TranslationVector::Zero();  ///< at the reference
  Orbit orbit;
};

/// The bundle's poses follow from the motion; its pose_fixed is ignored. Points, motion and poses
/// are changed in place.
struct FreeBodyProblem {
  BundleProblem bundle;
  std::span<const PoseTime> times;  ///< by pose, in any order
  FreeBodyMotion* motion = nullptr;
  double shape_sigma = kShapeSigma;  ///< prior 1-sigma of each number of the shape
  double mass_centre_sigma =
      1.0;  ///< prior 1-sigma of each coordinate of the centre-of-mass offset in T
};

struct FreeBodyReport {
  BundleReport bundle;  ///< costs include the two priors
  /// Of the unknowns, points eliminated, by the observations' sigmas and the priors. T's axes,
  /// origin and unit, which no image determines, are constrained in the mean over the poses.
  FreeBodyInformation information = FreeBodyInformation::Zero();
};

/// Levenberg-Marquardt by Ceres over the twenty unknowns alone, by variable projection: each trial
/// motion has its points re-solved (decision 0043).
/// @return not usable if the motion diverges or moves a point behind a camera. The problem's
/// motion, poses and points are then invalid.
/// @cost for each trial a settling of all points, two to three linearisations of all observations;
/// for each motion that is kept one more and a dense system of twenty. Deterministic; heap by
/// adjustment_bytes_max().
/// @source Golub and Pereyra, Inverse Problems 19, 2003; Kaufman, BIT 15, 1975 (variable
/// projection).
FreeBodyReport adjust_free_body(const FreeBodyProblem& problem, const BundleOptions& options);

}  // namespace polhode
