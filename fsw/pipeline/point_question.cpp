#include "pipeline/point_question.hpp"

#include <Eigen/Core>
#include <cmath>

#include "base/validity.hpp"
#include "bus/commands.hpp"
#include "bus/dynamics_telemetry.hpp"
#include "geometry/so3.hpp"
#include "motion/body_point.hpp"
#include "motion/published.hpp"
#include "pipeline/published_errors.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

Eigen::Vector3d to_vector(const std::array<double, 3>& a) { return {a[0], a[1], a[2]}; }

std::array<double, 3> to_array(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Reason why the request is rejected, or empty.
std::string_view objection(const PointQuestion& asked, const Component::State& s) {
  if (s.mapping.map.landmark_count == 0) {
    return "no map";
  }
  if (!to_vector(asked.p_T).allFinite()) {
    return "point is no number";
  }
  const double norm = to_vector(asked.normal_T).norm();
  if (norm != 0.0 && !(std::abs(norm - 1.0) < bus::kNormTolerance)) {
    return "normal is no unit vector";
  }
  if (!validity::is_time(asked.timestamp_ns) || asked.timestamp_ns < s.clock.timestamp_ns) {
    return "time is before the last frame";
  }
  if (asked.target_frame != s.mapping.target_frame) {
    return "point is of another frame T";
  }
  return {};
}

/// Values that are too uncertain keep their flag at false.
void put_point(const PredictedPoint& found,
               const Eigen::Vector3d& normal_T,
               const Eigen::Matrix3d& R_CI,
               const PublishedErrors& errors,
               PointState* out) {
  const double unit = errors.unit.metres_per_mu;
  const double by_scale_sigma = errors.unit.relative_sigma;
  const Eigen::Vector3d p_C = R_CI * found.p_I * unit;
  PoseCovariance covariance = scaled(turned(R_CI, found.covariance), unit);
  widen(errors.camera, p_C.norm(), &covariance);
  const Eigen::Matrix3d covariance_p =
      covariance.bottomRightCorner<3, 3>() + by_scale(p_C, by_scale_sigma);
  const bool attitude_known =
      worst_sigma(covariance.topLeftCorner<3, 3>()) < bus::kAttitudeSigmaMax_rad;
  out->position_valid =
      attitude_known && worst_sigma(covariance_p) < bus::kPositionSigmaMax * p_C.norm();
  if (out->position_valid) {
    out->p_C = to_array(p_C);
    out->cov_p = upper_triangle<6>(covariance_p);
  }
  out->velocity_valid = out->position_valid && found.by_dynamics;
  if (out->velocity_valid) {
    const Eigen::Vector3d v_C = R_CI * found.v_I * unit;
    const Eigen::Matrix3d covariance_v =
        unit * unit * R_CI * found.covariance_v_I * R_CI.transpose();
    out->v_C = to_array(v_C);
    out->cov_v = upper_triangle<6>(Eigen::Matrix3d(covariance_v + by_scale(v_C, by_scale_sigma)));
  }
  const Eigen::Vector3d normal_C = R_CI * found.R_IT * normal_T;
  out->normal_valid = attitude_known && normal_C.norm() > 0.0;
  if (out->normal_valid) {
    const Eigen::Matrix3d turning = hat(normal_C.normalized());
    out->normal_C = to_array(normal_C.normalized());
    out->sigma_normal_rad =
        worst_sigma(turning * covariance.topLeftCorner<3, 3>() * turning.transpose());
  }
}

}  // namespace

std::string_view predict_point(const PointQuestion& asked,
                               const Component::State& s,
                               PointState* answer) {
  if (const std::string_view why = objection(asked, s); !why.empty()) {
    return why;
  }
  const PublishedErrors errors = published_errors(s);
  const Eigen::Vector3d p_T = to_vector(asked.p_T) / errors.unit.metres_per_mu;
  const Result<PredictedPoint> found = polhode::predict_point(
      p_T, asked.timestamp_ns, s.mapping.drift, s.configuration.parameters.motion, s.motion);
  if (!found) {
    return "no motion is known so far ahead";
  }
  PointState out;
  out.timestamp_ns = asked.timestamp_ns;
  out.from_timestamp_ns = s.clock.timestamp_ns;
  out.scale_known = errors.unit.known;
  out.scale_number = errors.unit.number;
  out.dynamics = found.value().by_dynamics ? bus::dynamics_of(s.motion.model) : bus::kDynamicsLocal;
  put_point(found.value(), to_vector(asked.normal_T), s.motion.R_IC.transpose(), errors, &out);
  *answer = out;
  return {};
}

}  // namespace polhode
