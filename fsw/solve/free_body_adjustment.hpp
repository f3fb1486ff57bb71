// Joint adjustment of points and of a free body's motion to their images: the poses are those of
// one torque-free (or orbiting) rigid body, whatever their number.
//
// Poses that are free to move drift, because each is placed by the landmarks of the last few; a
// body's motion has twenty unknowns, and nothing in them drifts.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "solve/bundle_adjustment.hpp"
#include "solve/mass_centre_fit.hpp"
#include "solve/rigid_body.hpp"

namespace polhode {

/// Those of the turning, then those of the path.
inline constexpr int kFreeBodyUnknowns = kTurningUnknowns + kPathUnknowns;
using FreeBodyVector = Eigen::Matrix<double, kFreeBodyUnknowns, 1>;
using FreeBodyInformation = Eigen::Matrix<double, kFreeBodyUnknowns, kFreeBodyUnknowns>;

/// When a pose was seen, and by an observer of which attitude.
struct PoseTime {
  double time_s = 0.0;  ///< counted as the motion's reference and the orbit's
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();
};

struct FreeBodyMotion {
  TurningState reference;
  InertiaShape shape = InertiaShape::Zero();
  PathVector path = PathVector::Zero();  ///< at the reference
  Orbit orbit;
};

/// The bundle's poses follow from the motion; none may be held. Point, motion and poses are changed
/// in place.
struct FreeBodyProblem {
  BundleProblem bundle;
  std::span<const PoseTime> times;  ///< by pose, in any order
  FreeBodyMotion* motion = nullptr;
  double shape_sigma = 1.5;  ///< 1-sigma beforehand of each number of the shape,
  double lever_sigma = 1.0;  ///< and of the mass centre's place in T
};

struct FreeBodyReport {
  BundleReport bundle;  ///< costs contain what the two priors cost
  /// Of the unknowns, points eliminated, by the sightings' sigmas and the priors. T's axes, origin
  /// and unit, which no image tells, are held where the poses have them on the mean.
  FreeBodyInformation information = FreeBodyInformation::Zero();
};

struct FreeBodyWorkspace {
  using ByUnknowns = Eigen::Matrix<double, 6, kFreeBodyUnknowns>;
  std::array<std::size_t, BundleWorkspace::kPoses> in_order_of_time{};
  std::array<ByUnknowns, BundleWorkspace::kPoses> pose_by_unknowns{};  ///< (phi, uvs) of each pose
};

/// Levenberg-Marquardt over the twenty unknowns alone, by variable projection: each trial has its
/// points settled, so that a motion is judged by the points that suit it. Damping on points as well
/// would hold back the motion, which moves all of them.
/// @return not usable, the problem's poses and points then mean nothing, where the motion puts a
/// point behind a camera or runs away.
/// @cost a system as adjust_bundle()'s for each motion that is kept, two to three linearisations of
/// all sightings for each that is tried. No heap; deterministic.
/// @source Golub and Pereyra, Inverse Problems 19, 2003 (variable projection).
FreeBodyReport adjust_free_body(const FreeBodyProblem& problem,
                                const BundleOptions& options,
                                BundleWorkspace* workspace,
                                FreeBodyWorkspace* own);

}  // namespace polhode
