// Prediction of a point of the body and of its surface normal, for the planner of a capture.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "base/result.hpp"
#include "geometry/pose.hpp"
#include "map/drift.hpp"
#include "motion/motion_estimate.hpp"
#include "motion/options.hpp"

namespace polhode {

/// Steps of the integration for one request: 100 rad, about 2 ms with its derivatives.
inline constexpr int kPointStepsMax = 2000;

/// A point in I, seen from the observer, and the body's attitude there. Unit of the poses.
struct PredictedPoint {
  Eigen::Matrix3d R_IT = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_I = Eigen::Vector3d::Zero();
  Eigen::Vector3d v_I = Eigen::Vector3d::Zero();       ///< of the dynamics; else zero
  PoseCovariance covariance = PoseCovariance::Zero();  ///< of (phi, p_I) as in pose.hpp
  Eigen::Matrix3d covariance_v_I = Eigen::Matrix3d::Zero();
  bool by_dynamics = false;  ///< else by the last poses alone
};

/// By the dynamics where they are valid; else by the last poses, and then at most
/// kPredictionsAhead_s.front() after them. The covariance includes errors of motion, mass centre
/// and map, but not of scale and camera.
/// @param p_T           the point, taken as exact.
/// @param timestamp_ns  not before the last pose.
/// @errors Degenerate (no valid motion reaches the time in kPointStepsMax steps).
Result<PredictedPoint> predict_point(const Eigen::Vector3d& p_T,
                                     std::int64_t timestamp_ns,
                                     const MapDrift& drift,
                                     const MotionOptions& options,
                                     const MotionEstimate& motion);

}  // namespace polhode
