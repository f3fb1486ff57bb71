// A rigid model as inertia ratios, principal axes, periods and momentum, each with its sigma and
// its observability.
#pragma once

#include <Eigen/Core>
#include <array>

#include "base/result.hpp"
#include "motion/model.hpp"
#include "motion/trajectory.hpp"

namespace polhode {

/// A number with its observability. Where unobserved, `value` is not valid and must not be shown.
struct Estimated {
  double value = 0.0;
  double sigma = 0.0;
  Observability observability = Observability::kUnobserved;
};

struct BodyDynamics {
  /// Principal axes in T as columns, right-handed, by growing moment; largest component positive
  /// for the first two.
  Eigen::Matrix3d R_TP = Eigen::Matrix3d::Identity();
  std::array<double, 3> sigma_axis_rad{};  ///< of each axis' direction, worst axis
  std::array<Observability, 3> axes{};
  Estimated middle_over_least;  ///< ratio of principal moments
  Estimated largest_over_least;
  /// w_T repeats after this. For a body of revolution: rotation about its axis, relative to the
  /// axis' precession.
  Estimated spin_period_s;
  /// Mean period of the rotation about the angular momentum.
  Estimated precession_period_s;
  Estimated rotation_period_s;  ///< of one rotation at the present rate
  Eigen::Vector3d momentum_axis_I =
      Eigen::Vector3d::UnitZ();  ///< direction of the angular momentum
  double sigma_momentum_axis_rad = 0.0;
  Observability momentum_axis = Observability::kUnobserved;
  /// Mass centre seen from T's origin, along the columns of `mass_centre_axes_T`, best known first.
  Eigen::Matrix3d mass_centre_axes_T = Eigen::Matrix3d::Identity();
  std::array<Estimated, 3> mass_centre{};
  Eigen::Vector3d v_I = Eigen::Vector3d::Zero();  ///< of the mass centre
  Eigen::Matrix3d covariance_v_I = Eigen::Matrix3d::Zero();
};

/// @errors Degenerate (model not accepted).
Result<BodyDynamics> describe_dynamics(const RigidModel& model);

/// Period after which the rate of a free body repeats in its own axes. Infinite for rotation about
/// the middle axis.
/// @source Landau and Lifshitz, Mechanics, section 37.
double spin_period_s(const Eigen::Matrix3d& J_T, const Eigen::Vector3d& w_T_rad_s);

/// 2 pi over the mean rate at which a principal axis moves about the angular momentum: the axis of
/// the largest or of the least moment, whichever the rate circles.
double precession_period_s(const Eigen::Matrix3d& J_T, const Eigen::Vector3d& w_T_rad_s);

}  // namespace polhode
