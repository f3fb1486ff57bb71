// Does the body still move as the model has it? Poses judge that one by one.
#pragma once

#include <cstdint>
#include <optional>

#include "geometry/pose.hpp"
#include "motion/motion_estimate.hpp"

namespace polhode {

struct PoseJudgement {
  /// The model is gone, and what was before the first pose that departed.
  bool begun_anew = false;
  /// Time of the pose before, which had departed: it was wrong, and is forgotten.
  std::optional<std::int64_t> withdrawn_ns;
};

/// Nothing has moved since the last picture, though it did until then: it has been delivered twice,
/// encoded anew. Its pose says nothing of the motion. The same one a sixth time is a body at rest.
/// @param seen_C  remembered where it is no repeat.
[[nodiscard]] bool repeats_last(const PoseSample& seen_C, MotionEstimate* motion);

/// A measured pose, in I: is it where the model has it, and does the model's motion lead there from
/// the last pose that it led to? The second tells a change of the rate at once: the map's drift and
/// the model's phase cancel.
/// @param drift_I  error that poses of one visible face share.
[[nodiscard]] PoseJudgement judge_pose(const PoseSample& sample,
                                       const PoseCovariance& drift_I,
                                       MotionEstimate* motion);

/// A pose that says nothing of the motion: the map has moved under it.
void pass_over_pose(MotionEstimate* motion);

/// The map has moved, and the last pose seen is this one in it: the same picture shows it again.
void move_seen(const Pose& pose_C, MotionEstimate* motion);

/// As if no pose had been seen yet: none repeats the last one.
void forget_seen(MotionEstimate* motion);

/// Another model, or none. What poses have said of the last one goes on only from an accepted one
/// to an accepted one.
void replace_model(const RigidModel& model, MotionEstimate* motion);

/// The first question alone, for a pose that was there before the model. After three that are
/// elsewhere the model is refused.
void judge_place(const PoseSample& sample, const PoseCovariance& drift_I, MotionEstimate* motion);

/// A fit to more of the pictures has refused the model.
void refute_model(MotionEstimate* motion);

}  // namespace polhode
