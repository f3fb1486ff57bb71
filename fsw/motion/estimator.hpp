// What is remembered of the target's motion from frame to frame, and what is said and predicted
// from it.
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

/// What a fit of motion and map together says of the map's drift.
struct DriftByModel {
  PoseCovariance covariance_C = PoseCovariance::Zero();  ///< of T, at the model's reference time
  double relative_speed_sigma = 1.0;  ///< 1-sigma of the angular speed, as a part of it
};

/// The observer's attitude, as reported for this frame; what is not a rotation leaves the last one.
/// @return with the first attitude of a run the rotation from I as it was taken to be into I as it
/// is. The poses so
///         far are turned by it here, and the model is dropped.
std::optional<Eigen::Matrix3d> take_observer(const std::optional<Eigen::Quaterniond>& q_IC,
                                             MotionEstimate* motion);

/// A pose in C has been found.
/// @return is a new fit of the dynamics due? Never in paper mode.
[[nodiscard]] bool remember_pose(std::int64_t timestamp_ns,
                                 const Pose& pose,
                                 const PoseCovariance& covariance,
                                 const MotionOptions& options,
                                 MotionEstimate* motion);

/// A pose in C has been measured, by landmarks alone: does the model bear it out? After three that
/// are elsewhere it is refused. After two to which its motion does not lead the body moves
/// otherwise than before: the model goes, and the poses before these two with it. Where its motion
/// had led to few poses it is the model that was wrong, and only that goes.
/// Where the motion has begun anew, fits that are under way are of the one before.
[[nodiscard]] PoseJudgement check_pose(std::int64_t timestamp_ns,
                                       const Pose& pose,
                                       const PoseCovariance& covariance,
                                       const MapDrift& drift,
                                       MotionEstimate* motion);

/// The poses to fit dynamics to, as the map has them now.
void prepare_fit(const Map& map,
                 const MapDrift& drift,
                 const MotionOptions& options,
                 MotionEstimate* motion,
                 MotionSnapshot* snapshot);

/// A fit comes back: the poses since it was prepared judge it as they would have.
/// @param poses_fitted  value of poses_since_fit when it was prepared.
void take_fit(const RigidModel& model,
              std::int64_t fitted_to_ns,
              std::uint32_t poses_fitted,
              const MapDrift& drift,
              MotionEstimate* motion);

/// The model of a map that was fitted with it as a free body's: it stands for all poses so far.
/// @return the drift that is left in the map; nothing where the model tells no translation.
std::optional<DriftByModel> take_joint_fit(const RigidModel& model, MotionEstimate* motion);

/// The poses of an initialisation's keyframes, in order of time and in I, come into the past or
/// replace what is there at their times. The model is dropped.
void restate_poses(std::span<const PoseSample> start, MotionEstimate* motion);

/// The pose at the keyframe's time, where there is one, becomes the keyframe's.
void move_pose(const Keyframe& keyframe, MotionEstimate* motion);

/// All poses go along with their keyframes, as a rate from poses before and after a jump would be
/// wrong.
/// @return are there poses later than `adjusted_to_ns`?
bool move_poses_with_map(const Map& map, std::int64_t adjusted_to_ns, MotionEstimate* motion);

/// T is another one from here on: nothing of the poses so far holds. The observer's attitude stays.
void reset_poses(MotionEstimate* motion);

/// Rates at the last pose: by the dynamics where they hold, else by a local fit, or by the last two
/// poses in paper mode. Velocity in C, unit of the poses. @errors as estimate_rates().
Result<RateEstimate> rates_now(const MotionEstimate& motion,
                               const MapDrift& drift,
                               const MotionOptions& options);

/// The pose in C at a time not before the last pose's, for an observer with the attitude R_IC. A
/// pose that departs from the motion is passed over.
/// @errors as predict_pose() of motion/rates.hpp.
Result<PosePrediction> predict_by_motion(const MotionEstimate& motion,
                                         const MapDrift& drift,
                                         const MotionOptions& options,
                                         std::int64_t timestamp_ns,
                                         const Eigen::Matrix3d& R_IC);

/// As predict_by_motion(), and the last pose where nothing is known of the motion; nothing without
/// a pose. Never behind the camera: where the motion leads through it the last position stands.
std::optional<PosePrediction> predict_or_hold(const MotionEstimate& motion,
                                              const MapDrift& drift,
                                              const MotionOptions& options,
                                              std::int64_t timestamp_ns,
                                              const Eigen::Matrix3d& R_IC);

/// What tracking is told of a predicted pose: it, and how far the motion behind it has been
/// checked.
ExpectedPose expected_at(const PosePrediction& predicted,
                         std::int64_t timestamp_ns,
                         const MotionEstimate& motion);

/// What tracking is told where the last pose departs from the motion and is right: the body has
/// gone on from it. Nothing where no pose departs.
std::optional<ExpectedPose> expected_from_departed(const MotionEstimate& motion,
                                                   const MapDrift& drift,
                                                   const MotionOptions& options,
                                                   std::int64_t timestamp_ns);

/// The pose in C by a model that was fitted with the map; nothing where there is none that holds.
std::optional<PosePrediction> pose_by_joint_model(const MotionEstimate& motion,
                                                  const MotionOptions& options,
                                                  std::int64_t timestamp_ns,
                                                  const Eigen::Matrix3d& R_IC);

/// The last pose as an observer with the attitude R_IC would see it, had the target not moved
/// since; there must be one.
Pose last_pose_seen(const MotionEstimate& motion, const Eigen::Matrix3d& R_IC);

}  // namespace polhode
