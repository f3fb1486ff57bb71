// The run's motion from all frames: poses in the body frame, rates from the dynamics or from both
// sides.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "app/servicer_attitude.hpp"
#include "motion/pose_history.hpp"
#include "motion/rigid_model.hpp"
#include "pipeline/ground_view.hpp"
#include "pipeline/smooth.hpp"

namespace polhode::platform {

/// Body frame B in T: p_B = R_TB^T (p_T - centroid_T); lengths in the published unit.
struct BodyFrame {
  Eigen::Matrix3d R_TB = Eigen::Matrix3d::Identity();
  Eigen::Vector3d centroid_T = Eigen::Vector3d::Zero();
};

/// Whether the last map was tracked long enough to be confirmed: one that was lost after fewer
/// poses than check a motion is wrong, and so are poses from it.
[[nodiscard]] bool is_confirmed(std::span<const MotionState> published);

/// The valid poses, of B seen from the servicer in axes that do not turn, with lengths in the
/// published unit.
std::vector<PoseSample> samples_in_body(const std::vector<SmoothedPose>& poses,
                                        std::span<const MotionState> published,
                                        const BodyFrame& body,
                                        double metres_per_mu,
                                        const ServicerAttitude& servicer);

/// The drift that poses of the converged map still have, in the published unit.
PoseCovariance converged_drift(const GroundView& view);

/// Rigid-body dynamics through all samples (every so-many-th where there are more than a fit
/// takes).
RigidModel model_of(std::span<const PoseSample> samples,
                    double body_radius,
                    const GroundView& view);

/// The model that the map was fitted with (motion_is_of_map()), in B and the published unit, where
/// there is one and the samples lie on it: they were placed by it, so that a fit to them would find
/// no noise and take itself for exact.
std::optional<RigidModel> model_of_map(std::span<const PoseSample> samples,
                                       const BodyFrame& body,
                                       const GroundView& view);

/// What the rows of a run are made of.
struct RunPoses {
  const std::vector<SmoothedPose>& poses;    ///< one a frame
  const std::vector<PoseSample>& samples;    ///< the valid ones, by samples_in_body()
  std::span<const MotionState> published{};  ///< one a frame
};

/// One row a frame. Where the model is accepted, pose and rates are the model's, in frames without
/// a measured pose too; elsewhere the measured pose and a local fit. Empty where there is neither.
std::vector<MotionState> smoothed_motion(const RunPoses& run_poses,
                                         const RigidModel& model,
                                         const ServicerAttitude& servicer,
                                         const GroundView& view);

}  // namespace polhode::platform
