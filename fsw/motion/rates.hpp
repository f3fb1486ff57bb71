// Rates at one time, and the pose at another, from a history of poses. Causal when the history ends
// at that time.
//
// Rotation is followed in the rotation vector psi relative to the reference attitude, R_CT(t) =
// R_CT(t_ref) exp(psi(t)): linear in time for a constant rate at any angle, the same curve (but for
// a constant rotation) whether the rate is constant in the body or in space, and with w_T = d psi /
// dt at the reference.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/result.hpp"
#include "geometry/pose_prediction.hpp"
#include "motion/motion_state.hpp"
#include "motion/options.hpp"
#include "motion/pose_history.hpp"

namespace polhode {

struct RateEstimate {
  Eigen::Vector3d w_T_rad_s = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_w_T = Eigen::Matrix3d::Zero();  ///< (rad/s)^2
  Eigen::Vector3d v_C = Eigen::Vector3d::Zero();  ///< of T's origin, unit of the poses per second
  Eigen::Matrix3d covariance_v_C = Eigen::Matrix3d::Zero();
  Pose pose;                       ///< the fitted (smoothed) pose at the reference
  std::size_t rotation_poses = 0;  ///< poses that the rotation was fitted to
  std::size_t position_poses = 0;
  double rotation_span_s = 0.0;  ///< largest distance in time among them
  double position_span_s = 0.0;
  double rotation_misfit =
      1.0;  ///< factor on the declared covariance, >= 1; included in covariance_w_T
  double position_misfit = 1.0;
};

/// Rates at the last pose of `history`, from it and earlier ones.
/// @param history  time strictly increasing, in one unit of length.
/// @errors TooFewObservations (under 2 poses), Degenerate (a covariance is not positive definite).
/// @limit  a body that turns by more than pi between two poses is seen as turning the other way.
/// @cost   at most options.window_poses_max poses; see fit_local().
Result<RateEstimate> estimate_rates(std::span<const PoseSample> history,
                                    const MotionOptions& options);

/// Rates at `history[index]` from poses on both sides: for the end of a run.
Result<RateEstimate> estimate_rates_at(std::span<const PoseSample> history,
                                       std::size_t index,
                                       const MotionOptions& options);

/// Longest interval over which two poses determine a rate. Over a longer one the number of turns is
/// ambiguous, for a body at the fastest rate between some of these poses (beyond 3 sigma). Infinite
/// for a body at rest.
[[nodiscard]] double unambiguous_interval_max_s(std::span<const PoseSample> poses);

/// Adds the effect of the map's drift on rates fitted within one visible face. The drift changes by
/// about its own size over 0.8 rad of rotation, which appears as motion.
/// @param turn_sigma  1-sigma of a relative error common to all rotations. It applies to the rate,
/// too, except about the line of sight: that rotation is seen directly in the images.
void widen_by_drift(const PoseCovariance& drift, double turn_sigma, RateEstimate& rates);

/// Covariance of a pose predicted from the last ones by the map's drift: the drift itself, and its
/// effect on their rates over the rotation until then. Drift and turn_sigma as above.
PoseCovariance drift_until(const Pose& predicted,
                           const Pose& last,
                           const PoseCovariance& drift,
                           double turn_sigma);

/// The pose at `timestamp_ns`, at or after the last one of `history`, by the motion so far.
/// @errors TooFewObservations (under 2 poses: the motion is unknown), Degenerate (as above, or the
/// time is before the last pose).
Result<PosePrediction> predict_pose(std::span<const PoseSample> history,
                                    std::int64_t timestamp_ns,
                                    const MotionOptions& options);

/// Copies rates into the published state and sets both flags; sigmas are those of the worst axis.
void publish(const RateEstimate& rates, MotionState& state);

/// 1-sigma of the worst direction of a 3x3 covariance.
[[nodiscard]] double worst_sigma(const Eigen::Matrix3d& covariance);

}  // namespace polhode
