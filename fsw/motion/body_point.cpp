#include "motion/body_point.hpp"

#include <cmath>

#include "geometry/so3.hpp"
#include "motion/estimator.hpp"
#include "motion/look_ahead.hpp"

namespace polhode {
namespace {

/// Of a point that is fixed to the body instead of T's origin. @param arm_I  from there to the
/// point
PoseCovariance of_point(const PoseCovariance& covariance, const Eigen::Vector3d& arm_I) {
  PoseCovariance by = PoseCovariance::Identity();
  by.bottomLeftCorner<3, 3>() = -hat(arm_I);
  return by * covariance * by.transpose();
}

/// Is the integration to that time short enough? Assumes a constant rate.
bool within_steps(const RigidModel& model, std::int64_t timestamp_ns) {
  const double rate_rad_s = model.reference.w_T_rad_s.norm() + model.orbit.mean_motion_rad_s;
  const double turn_rad = rate_rad_s * std::abs(seconds_between(model.reference_ns, timestamp_ns));
  return turn_rad <= kPointStepsMax * kRotationStepAngle_rad;
}

/// The point takes the place of T's origin, so that its errors and those of attitude and rate are
/// taken together (decision 0108).
Result<PredictedPoint> by_dynamics(const Eigen::Vector3d& p_T,
                                   std::int64_t timestamp_ns,
                                   const MapDrift& drift,
                                   const MotionEstimate& motion) {
  if (!motion.model.translation_known || !within_steps(motion.model, timestamp_ns)) {
    return ErrorCode::kDegenerate;
  }
  RigidModel about_point = motion.model;
  about_point.path.tail<3>() -= p_T;
  const Result<MotionPrediction> at = predict_motion(about_point, timestamp_ns);
  if (!at) {
    return at.error();
  }
  const MotionPrediction& found = at.value();
  return PredictedPoint{
      .R_IT = found.pose.R_CT,
      .p_I = found.pose.p_CT,
      .v_I = found.v_I,
      .covariance = found.covariance +
                    of_point(turned(motion.R_IC, drift.reanchoring), found.pose.R_CT * p_T),
      .covariance_v_I = found.covariance_v_I,
      .by_dynamics = true};
}

Result<PredictedPoint> by_poses(const Eigen::Vector3d& p_T,
                                std::int64_t timestamp_ns,
                                const MapDrift& drift,
                                const MotionOptions& options,
                                const MotionEstimate& motion) {
  const Result<PosePrediction> at =
      predict_by_motion(motion, drift, options, timestamp_ns, motion.R_IC);
  if (!at) {
    return ErrorCode::kDegenerate;
  }
  const Pose& pose_C = at.value().pose;
  const PoseCovariance covariance_C =
      at.value().covariance +
      drift_until(pose_C,
                  turned(motion.R_IC.transpose(), motion.recent.back().pose),
                  covariance(drift),
                  turn_sigma(drift));
  const Pose pose = turned(motion.R_IC, pose_C);
  const Eigen::Vector3d arm_I = pose.R_CT * p_T;
  return PredictedPoint{.R_IT = pose.R_CT,
                        .p_I = pose.p_CT + arm_I,
                        .covariance = of_point(turned(motion.R_IC, covariance_C), arm_I)};
}

}  // namespace

Result<PredictedPoint> predict_point(const Eigen::Vector3d& p_T,
                                     std::int64_t timestamp_ns,
                                     const MapDrift& drift,
                                     const MotionOptions& options,
                                     const MotionEstimate& motion) {
  Result<PredictedPoint> predicted = ErrorCode::kDegenerate;
  if (dynamics_hold(motion, options)) {
    predicted = by_dynamics(p_T, timestamp_ns, drift, motion);
  }
  if (predicted || motion.recent.empty() || motion.repeats > 0) {
    return predicted;
  }
  const double ahead_s = seconds_between(motion.recent.back().timestamp_ns, timestamp_ns);
  if (ahead_s > kPredictionsAhead_s.front()) {
    return predicted;
  }
  return by_poses(p_T, timestamp_ns, drift, options, motion);
}

}  // namespace polhode
