// The dynamics and the prediction of motion_model.json.
#pragma once

#include <nlohmann/json.hpp>

#include "motion/rigid_model.hpp"
#include "motion/trajectory.hpp"
#include "solve/camera_verdict.hpp"

namespace polhode::platform {

using Json = nlohmann::ordered_json;

Json to_json(const Eigen::Vector3d& v);

/// 1-sigma of each component.
Json sigmas(const Eigen::Matrix3d& covariance);

const char* name(Observability observability);

/// Whether the poses confirm a free rigid body, and why not.
Json fit_json(const RigidModel& model, const MotionOptions& options);

/// Adds rates, principal axes, inertia ratios, periods, angular momentum, velocity and mass centre
/// to `out`; what is unobserved is null. The model must be accepted.
/// @param R_CI         takes inertial components to those of the camera at the model's reference.
/// @param scale_sigma  1-sigma of the scale over the scale: lengths' sigmas contain it.
void add_dynamics(const RigidModel& model,
                  const Eigen::Matrix3d& R_CI,
                  double scale_sigma,
                  Json* out);

/// Errors of predicted poses beside the model's own.
struct SharedErrors {
  double scale_sigma = 0.0;  ///< 1-sigma of the scale over the scale
  CameraFinding camera{};
  double body_radius = 1.0;  ///< unit of the poses
};

/// Adds `prediction`, rows from now to 30 min ahead with the camera held as it is at the reference,
/// and `prediction_horizon_s`: the longest of them whose attitude is sure to 5 deg (1 sigma, worst
/// axis), null where none is.
void add_prediction(const RigidModel& model,
                    const Eigen::Matrix3d& R_CI,
                    const SharedErrors& errors,
                    Json* out);

}  // namespace polhode::platform
