// The run's motion from all frames: poses in the body frame, rates from both sides.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "motion/pose_history.hpp"
#include "pipeline/component.hpp"
#include "pipeline/smooth.hpp"

namespace polhode::platform {

/// Body frame B in T: p_B = R_TB^T (p_T - centroid_T); lengths in the published unit.
struct BodyFrame {
  Eigen::Matrix3d R_TB = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centroid_T = Eigen::Vector3d::Zero();
};

/// The valid poses, of B, with lengths in the published unit.
std::vector<PoseSample> samples_in_body(const std::vector<SmoothedPose>& poses,
                                        std::span<const MotionState> published,
                                        const BodyFrame& body,
                                        double metres_per_mu);

/// One row a frame; empty where the frame has no pose.
std::vector<MotionState> smoothed_motion(const std::vector<SmoothedPose>& poses,
                                         const std::vector<PoseSample>& samples,
                                         std::span<const MotionState> published,
                                         const Component::State& state);

}  // namespace polhode::platform
