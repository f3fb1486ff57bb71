// The frame's answer: motion state, packet, observations.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// Writes a pose with its sigmas into a motion state; of the two quaternions of one rotation the
/// one nearer to `q_last`, which becomes the one written.
void fill_pose(const Pose& pose,
               const PoseCovariance& covariance,
               std::array<double, 4>* q_last,
               MotionState* motion);

/// The same pose with lengths multiplied by `unit`.
Pose scaled(const Pose& pose, double unit);
PoseCovariance scaled(const PoseCovariance& covariance, double unit);

/// What the scale's own error adds to the covariance of a length, in its unit.
Eigen::Matrix3d by_scale(const Eigen::Vector3d& length, const ScaleState& scale);
PoseCovariance by_scale(const Pose& pose, const ScaleState& scale);

/// Fills `state->output`. Every accepted frame gets exactly one motion packet, valid or not.
void publish(FrameUse use, std::int64_t timestamp_ns, Component::State* state);

}  // namespace polhode
