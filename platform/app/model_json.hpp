// motion_model.json: how the target moves, in numbers that outlast the run.
#pragma once

#include <filesystem>
#include <span>

#include "motion/rigid_model.hpp"
#include "motion/trajectory.hpp"
#include "solve/camera_verdict.hpp"

namespace polhode::platform {

struct ModelInput {
  std::span<const PoseSample> samples;  ///< in I
  const RigidModel& model;
  const MotionOptions& options;
  double body_radius = 1.0;  ///< half the body's largest dimension, unit of the poses
  bool scale_known = false;
  double scale_sigma =
      0.0;  ///< 1-sigma of the scale over the scale, which all lengths in metres share
  CameraFinding camera{};
  Eigen::Matrix3d R_CI = Eigen::Matrix3d::Identity();  ///< of the camera at the last sample
};

/// Writes the rigid-body model with its prediction, and beside it the paper's (sines through the
/// rates), whose sigmas are null where its poses are the rigid-body model's own; what the data do
/// not determine is null, with its reason.
void write_model_json(const std::filesystem::path& file, const ModelInput& input);

}  // namespace polhode::platform
