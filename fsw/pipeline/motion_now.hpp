// The motion as far as it is known at this frame: what is remembered of the poses, when the dynamics
// are fitted anew, and what is published and predicted from them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "map/map.hpp"
#include "motion/rates.hpp"
#include "motion/rigid_model.hpp"
#include "pipeline/component.hpp"

namespace polhode {

struct MotionNow {
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();  ///< the observer's attitude at this frame
  bool observer_known = false;  ///< it was told; else C stands in for I
  PoseHistory recent;  ///< in I, one by one; errors of single frames, without the map's drift
  PoseHistory past;    ///< as recent, thinned: what the dynamics are fitted to
  RigidModel model;  ///< of the last fit; used while it is accepted and the poses agree
  std::uint32_t poses_since_fit = 0;
  std::uint32_t poses_since_start = 0;  ///< found one by one; those of a start are right or wrong together
  std::uint32_t disagreements = 0;  ///< poses in succession that are not where the model has them
};

/// The observer's attitude at the frame that begins: the frame's own, else the one last told by command
/// and turned on at its rate. What is not a rotation leaves the last one. With the first attitude of a
/// run the poses so far, for which C stood in for I, are turned into I.
void set_observer(const StepInput& input, Component::State* state);

/// A pose found at `timestamp_ns`, in C. The dynamics are fitted anew when that is due.
void remember_motion(std::int64_t timestamp_ns,
                     const Pose& pose,
                     const PoseCovariance& covariance,
                     Component::State* state);

using StartPoses = FixedVector<PoseSample, limits::kKeyframes>;

/// The poses of a start's keyframes, in order of time and in I, come into the past or replace what is
/// there at their times.
void restate_motion(std::span<const PoseSample> start, Component::State* state);

/// The fit that comes back: the poses since it was asked for judge it as they would have.
void take_fit(Component::State* state);

/// The model of a map that was fitted with it as a free body's: it stands for all poses so far, and the map
/// has no other drift than the model's own error.
void take_joint_fit(const RigidModel& model, Component::State* state);

/// The pose at the keyframe's time, where there is one, has become the keyframe's by an adjustment.
void move_pose(const Keyframe& keyframe, Component::State* state);

/// An adjustment is taken in: all poses go along with their keyframes, as a rate from poses before and after a jump
/// would be wrong.
/// @return have frames come since its newest keyframe?
bool move_poses_with_map(std::int64_t adjusted_to_ns, Component::State* state);

/// What the poses were, or how they are taken to move, no longer holds, and neither does what is being fitted to them.
void forsake_model(Component::State* state);

/// T is another one from here on: nothing of the poses so far holds.
void forget_motion(Component::State* state);

/// Rates at this frame, which has a pose: by the dynamics where they hold, else by a local fit, or by
/// the last two poses in paper mode. Velocity in C, unit of the poses. @errors as estimate_rates().
Result<RateEstimate> rates_now(const Component::State& state);

/// The pose in C at a time not before the last pose's, for an observer with the attitude R_IC. @errors as predict_pose() of motion/rates.hpp.
Result<PosePrediction> predict_by_motion(const Component::State& state,
                                         std::int64_t timestamp_ns,
                                         const Eigen::Matrix3d& R_IC);

/// The pose in C by a model that was fitted with the map; nothing where there is none that holds.
std::optional<PosePrediction> pose_by_map_model(const Component::State& state,
                                                std::int64_t timestamp_ns,
                                                const Eigen::Matrix3d& R_IC);

/// A pose has been measured, by landmarks alone: does the model bear it out?
void check_motion(std::int64_t timestamp_ns,
                  const Pose& pose,
                  const PoseCovariance& covariance,
                  Component::State* state);

/// The last pose as an observer with the attitude R_IC would see it, had the target not moved since;
/// there must be one.
Pose last_pose_seen(const Component::State& state, const Eigen::Matrix3d& R_IC);

}  // namespace polhode
