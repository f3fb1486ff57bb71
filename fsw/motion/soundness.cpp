#include "motion/soundness.hpp"

#include "base/validity.hpp"

namespace polhode {
namespace {

using validity::is_at_least;
using validity::is_bool;
using validity::is_bounded;
using validity::is_covariance;
using validity::is_enum;
using validity::is_past;
using validity::is_positive_definite;
using validity::is_rotation;

bool is_valid(const PoseHistory& poses, std::int64_t now_ns) {
  if (poses.size() > PoseHistory::capacity()) {
    return false;
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (!is_valid(poses[i], now_ns) ||
        (i > 0 && poses[i].timestamp_ns <= poses[i - 1].timestamp_ns)) {
      return false;
    }
  }
  return true;
}

bool is_valid(const ResidualLevel& level) {
  return is_at_least(level.chi2_per_dof, 0.0) && is_at_least(level.scale2, 0.0) &&
         is_at_least(level.correlation, 1.0) && level.outliers <= limits::kMotionPoses &&
         level.outliers_at_end <= level.outliers;
}

}  // namespace

bool is_valid(const PoseSample& sample, std::int64_t now_ns) {
  const PoseCovariance& C = sample.covariance;
  return is_past(sample.timestamp_ns, now_ns) && is_rotation(sample.pose.R_CT) &&
         is_bounded(sample.pose.p_CT) && is_bounded(C) &&
         is_positive_definite(C.topLeftCorner<3, 3>()) &&
         is_positive_definite(C.bottomRightCorner<3, 3>());
}

bool is_valid(const RigidModel& model, std::int64_t now_ns) {
  constexpr double kShapeMax = 50.0;  // logarithms of ratios: exp() of it is finite
  if (!is_enum(model.status, ModelStatus::kResidualsTooLarge) ||
      !is_bool(model.translation_known) || !is_bool(model.of_map)) {
    return false;
  }
  if (!model.accepted()) {
    return true;  // nothing else of it is looked at
  }
  return is_past(model.reference_ns, now_ns) && is_bounded(model.reference.time_s) &&
         is_rotation(model.reference.R_IT) && is_bounded(model.reference.w_T_rad_s) &&
         is_bounded(model.shape) && model.shape.cwiseAbs().maxCoeff() <= kShapeMax &&
         is_bounded(model.path) && is_covariance(model.covariance) &&
         is_at_least(model.mass_centre_sigma, 0.0) &&
         is_at_least(model.orbit.mean_motion_rad_s, 0.0) && is_rotation(model.orbit.R_IH) &&
         is_valid(model.attitude) && is_valid(model.position) &&
         model.poses <= limits::kMotionPoses && is_at_least(model.span_s, 0.0);
}

bool is_valid_of_repeats(const MotionEstimate& motion, std::int64_t now_ns) {
  return is_bool(motion.last_seen.any) && is_at_least(motion.last_seen.moved_rad_s, 0.0) &&
         (!motion.last_seen.any || is_valid(motion.last_seen.pose_C, now_ns));
}

bool is_valid(const KnownBody& body) {
  // Nothing is known exactly: a fit divides by the sigmas.
  constexpr double kSigmaMin = 1e-9;
  const bool bounded = is_bool(body.known) && is_bounded(body.shape) &&
                       is_bounded(body.shape_sigma) && is_bounded(body.mass_centre_T) &&
                       is_bounded(body.mass_centre_sigma);
  return bounded && (!body.known || (body.shape_sigma.minCoeff() >= kSigmaMin &&
                                     body.mass_centre_sigma.minCoeff() >= kSigmaMin));
}

bool is_valid(const MotionEstimate& motion, std::int64_t now_ns) {
  return is_valid(motion.known_body) && is_rotation(motion.R_IC) &&
         is_bool(motion.observer_known) && is_valid(motion.recent, now_ns) &&
         is_valid(motion.past, now_ns) &&
         (motion.moves_so_since_ns == INT64_MIN || is_past(motion.moves_so_since_ns, now_ns)) &&
         motion.departures <= motion.recent.size() && is_valid_of_repeats(motion, now_ns) &&
         is_valid(motion.model, now_ns);
}

}  // namespace polhode
