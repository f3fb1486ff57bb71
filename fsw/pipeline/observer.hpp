// What a step asks of the motion room on behalf of the others: fits as jobs, and what must follow
// when the motion is found, moved or dropped.
#pragma once

#include <cstdint>
#include <span>

#include "motion/estimator.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// The observer's attitude at the frame that begins: the frame's own, else the one last reported by
/// command and turned on at its rate. With the first attitude of a run everything so far, for which
/// C stood in for I, is turned into I.
void set_observer(const StepInput& input, Component::State* state);

/// A pose found at `timestamp_ns`, in C. The dynamics are fitted anew when that is due.
void remember_motion(std::int64_t timestamp_ns,
                     const Pose& pose,
                     const PoseCovariance& covariance,
                     Component::State* state);

using StartPoses = FixedVector<PoseSample, limits::kKeyframes>;

/// The poses of an initialisation's keyframes: as restate_poses(); what is being fitted is for
/// nothing.
void restate_motion(std::span<const PoseSample> start, Component::State* state);

/// The fit that comes back.
void take_fit_job(Component::State* state);

/// A motion was fitted together with the map: the map has no other drift than the model's own
/// error.
void take_map_motion(const RigidModel& model, Component::State* state);

/// What the poses were, or how they are taken to move, no longer holds, and neither does what is
/// being fitted to them.
void drop_model(Component::State* state);

/// T is another one from here on: nothing of the poses so far holds.
void forget_motion(Component::State* state);

}  // namespace polhode
