// The state of the target's motion from frame to frame, with the rates and predictions from it.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <span>

#include "map/drift.hpp"
#include "map/map.hpp"
#include "map/track.hpp"
#include "motion/disturbance.hpp"
#include "motion/motion_estimate.hpp"
#include "motion/rates.hpp"
#include "motion/rigid_model.hpp"

namespace polhode {

/// The map's remaining drift, by a joint fit of motion and map.
struct DriftByModel {
  PoseCovariance covariance_C = PoseCovariance::Zero();  ///< of T, at the model's reference time
  double relative_speed_sigma = 1.0;  ///< 1-sigma of the angular speed, as a part of it
};

/// Stores the observer's attitude as reported for this frame; an invalid rotation keeps the last
/// one.
/// @return with the first attitude of a run, the rotation from the assumed I to the actual I. The
/// poses so far are rotated by it here, and the model is dropped.
std::optional<Eigen::Matrix3d> take_observer(const std::optional<Eigen::Quaterniond>& q_IC,
                                             MotionEstimate* motion);

/// Stores a pose that was found, in C.
/// @return true if a new fit of the dynamics is due; never in paper mode.
[[nodiscard]] bool remember_pose(std::int64_t timestamp_ns,
                                 const Pose& pose,
                                 const PoseCovariance& covariance,
                                 const MotionOptions& options,
                                 MotionEstimate* motion);

/// Checks the model against a pose in C that was measured by landmarks alone. Three disagreements
/// in succession refute the model. Two poses in succession that are inconsistent with the predicted
/// motion are a disturbance: the model is dropped, with all poses before these two. If the model
/// has predicted few poses, only the model is dropped.
/// After a disturbance, the fits under way are stale.
[[nodiscard]] PoseJudgement check_pose(std::int64_t timestamp_ns,
                                       const Pose& pose,
                                       const PoseCovariance& covariance,
                                       const MapDrift& drift,
                                       MotionEstimate* motion);

/// The poses for a fit of the dynamics, as corrected with the map.
void prepare_fit(const Map& map,
                 const MapDrift& drift,
                 const MotionOptions& options,
                 MotionEstimate* motion,
                 MotionSnapshot* snapshot);

/// Takes the result of a fit, and checks it against the poses since its preparation.
/// @param poses_fitted  value of poses_since_fit when it was prepared.
void take_fit(const RigidModel& model,
              std::int64_t fitted_to_ns,
              std::uint32_t poses_fitted,
              const MapDrift& drift,
              MotionEstimate* motion);

/// Takes the model of a joint fit with the map, which covers all poses so far.
/// @return the drift that remains in the map; nothing if the model has no translation.
std::optional<DriftByModel> take_joint_fit(const RigidModel& model, MotionEstimate* motion);

/// Inserts the poses of an initialisation's keyframes into the histories, in order of time and in
/// I. They replace poses at the same times. The model is dropped.
void restate_poses(std::span<const PoseSample> start, MotionEstimate* motion);

/// Replaces the pose at the keyframe's time, if there is one, by the keyframe's pose.
void move_pose(const Keyframe& keyframe, MotionEstimate* motion);

/// Moves all poses along with their keyframes; a jump between two poses would falsify the rate.
/// @return true if there are poses later than `adjusted_to_ns`.
bool move_poses_with_map(const Map& map, std::int64_t adjusted_to_ns, MotionEstimate* motion);

/// Discards all poses and the model, as the frame T is replaced. The observer's attitude stays.
void reset_poses(MotionEstimate* motion);

/// Rates at the last pose: by the dynamics where they are valid, else by a local fit, or by the
/// last two poses in paper mode. Velocity in C, unit of the poses. @errors as estimate_rates().
Result<RateEstimate> rates_now(const MotionEstimate& motion,
                               const MapDrift& drift,
                               const MotionOptions& options);

/// The pose in C at a time not before the last pose's, for an observer with the attitude R_IC. A
/// last pose inconsistent with the motion is skipped.
/// @errors as predict_pose() of motion/rates.hpp.
Result<PosePrediction> predict_by_motion(const MotionEstimate& motion,
                                         const MapDrift& drift,
                                         const MotionOptions& options,
                                         std::int64_t timestamp_ns,
                                         const Eigen::Matrix3d& R_IC);

/// As predict_by_motion(), or the last pose if the motion is unknown; nothing without a pose. The
/// last position replaces a predicted one behind the camera.
std::optional<PosePrediction> predict_or_hold(const MotionEstimate& motion,
                                              const MapDrift& drift,
                                              const MotionOptions& options,
                                              std::int64_t timestamp_ns,
                                              const Eigen::Matrix3d& R_IC);

/// The predicted pose as tracking needs it, with the extent to which its motion is validated.
ExpectedPose expected_at(const PosePrediction& predicted,
                         std::int64_t timestamp_ns,
                         const MotionEstimate& motion);

/// The prediction for tracking in case the last pose is inconsistent and correct: it continues from
/// that pose. Nothing if no pose is inconsistent.
std::optional<ExpectedPose> expected_from_departed(const MotionEstimate& motion,
                                                   const MapDrift& drift,
                                                   const MotionOptions& options,
                                                   std::int64_t timestamp_ns);

/// The pose in C by a model that was fitted with the map; nothing without a valid one.
std::optional<PosePrediction> pose_by_joint_model(const MotionEstimate& motion,
                                                  const MotionOptions& options,
                                                  std::int64_t timestamp_ns,
                                                  const Eigen::Matrix3d& R_IC);

/// The last pose as seen by an observer with the attitude R_IC, for a target at rest since then.
/// There must be a last pose.
Pose last_pose_seen(const MotionEstimate& motion, const Eigen::Matrix3d& R_IC);

}  // namespace polhode
