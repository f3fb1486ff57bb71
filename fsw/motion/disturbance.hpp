// Checks of each pose against the fitted model of the motion, to detect a disturbance of the body.
#pragma once

#include <cstdint>
#include <optional>

#include "geometry/pose.hpp"
#include "motion/motion_estimate.hpp"

namespace polhode {

struct PoseJudgement {
  /// True after a disturbance: the model and all poses before the first inconsistent one are
  /// dropped.
  bool begun_anew = false;
  /// Time of the previous pose if it was an outlier of the motion; it is removed.
  std::optional<std::int64_t> withdrawn_ns;
};

/// True for a repeated image, delivered twice and encoded again: a body that rotated until the last
/// pose shows no step. Such a pose carries no information on the motion. After five repeats in
/// succession the body counts as stopped.
/// @param seen_C  stored unless it is a repeat.
[[nodiscard]] bool repeats_last(const PoseSample& seen_C, MotionEstimate* motion);

/// Checks a measured pose, in I, against the model's pose and against the motion predicted from the
/// last consistent pose. The second check shows a change of the rate at once: the map's drift and
/// the model's phase error cancel.
/// @param drift_I  error that poses of one visible face share.
[[nodiscard]] PoseJudgement judge_pose(const PoseSample& sample,
                                       const PoseCovariance& drift_I,
                                       MotionEstimate* motion);

/// Resets the count of inconsistent poses, for a pose that cannot be checked: the map has moved.
void pass_over_pose(MotionEstimate* motion);

/// Replaces the stored last pose after a map correction, as a repeated image has the corrected
/// pose.
void move_seen(const Pose& pose_C, MotionEstimate* motion);

/// Discards the stored last pose, so the next pose cannot be a repeat.
void forget_seen(MotionEstimate* motion);

/// Replaces the model. The counts of inconsistent and of predicted poses are kept only if both the
/// old and the new model are accepted.
void replace_model(const RigidModel& model, MotionEstimate* motion);

/// Only the check against the model's pose, for a pose older than the model. Three disagreements in
/// succession refute the model.
void judge_place(const PoseSample& sample, const PoseCovariance& drift_I, MotionEstimate* motion);

/// Refutes the model, after a fit to more of the images was refused.
void refute_model(MotionEstimate* motion);

}  // namespace polhode
