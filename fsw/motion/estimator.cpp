#include "motion/estimator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/so3.hpp"
#include "motion/fit_poses.hpp"
#include "motion/paper.hpp"
#include "motion/residual_level.hpp"

namespace polhode {
namespace {

/// Not valid while a pose is inconsistent: either that pose or the motion is wrong.
bool holds(const MotionEstimate& m) { return m.model.accepted() && m.departures == 0; }

/// The poses without the inconsistent ones at the end; all poses if no other is left.
std::span<const PoseSample> led_to(const MotionEstimate& m) {
  const std::size_t count = m.recent.size();
  return m.recent.view().first(count > m.departures ? count - m.departures : count);
}

/// From the last of some poses, in I: by the model, or by a local fit to them if there is no valid
/// model with a translation. @errors as predict_by_motion().
Result<PosePrediction> predict_after(std::span<const PoseSample> poses,
                                     const MotionEstimate& m,
                                     const PoseCovariance& drift_in_I,
                                     const MotionOptions& options,
                                     std::int64_t timestamp_ns) {
  if (poses.empty()) {
    return ErrorCode::kTooFewObservations;
  }
  Result<MotionPrediction> at = ErrorCode::kDegenerate;
  if (m.model.accepted() && options.mode == MotionMode::kDynamics) {
    at = predict_on(m.model, poses.back(), drift_in_I, timestamp_ns);
  }
  if (!at || !at.value().translation_known) {
    return predict_pose(poses, timestamp_ns, options);
  }
  return PosePrediction{.pose = at.value().pose,
                        .covariance = at.value().covariance,
                        .rotation_poses = m.model.poses,
                        .position_poses = m.model.poses};
}

const Keyframe* keyframe_at(std::int64_t timestamp_ns, const Map& map) {
  const auto found =
      std::find_if(map.keyframes.begin(), map.keyframes.end(), [&](const Keyframe& k) {
        return k.used && k.timestamp_ns == timestamp_ns;
      });
  return found == map.keyframes.end() ? nullptr : &*found;
}

/// Adjustments move keyframes after their poses were stored. Later poses move with them.
void follow_map(const Map& map, PoseHistory& poses) {
  Pose from;  // pose of the last keyframe before and after the adjustment
  Pose to;
  for (PoseSample& sample : poses) {
    if (const Keyframe* keyframe = keyframe_at(sample.timestamp_ns, map)) {
      from = sample.pose;
      to = turned(keyframe->R_IC, keyframe->pose);
      sample.pose = to;
      continue;
    }
    // T has moved, not I: as MapCorrection::moved().
    const Eigen::Matrix3d R = sample.pose.R_CT * from.R_CT.transpose();
    sample.pose = {.R_CT = R * to.R_CT, .p_CT = R * (to.p_CT - from.p_CT) + sample.pose.p_CT};
  }
}

/// Merges poses, both in order of time. New ones replace old ones; a full table loses its oldest.
void merge(std::span<const PoseSample> news, PoseHistory& history) {
  const PoseHistory old = history;
  history.clear();
  std::size_t next = 0;
  for (const PoseSample& sample : news) {
    for (; next < old.size() && old[next].timestamp_ns < sample.timestamp_ns; ++next) {
      (void)remember(history, old[next]);
    }
    (void)remember(history, sample);
  }
  for (; next < old.size(); ++next) {
    (void)remember(history, old[next]);  // refused if a new pose has replaced it
  }
}

/// 1-sigma of the angular speed, as a part of it; 1 for a body at rest.
double relative_speed_sigma(const MotionPrediction& now) {
  const Eigen::Vector3d& w = now.w_T_rad_s;
  const double sigma = std::sqrt(std::max(0.0, w.dot(now.covariance_w_T * w)));
  return sigma < w.squaredNorm() ? sigma / w.squaredNorm() : 1.0;
}

/// Is the last interval far longer than the shortest? Then the number of turns over it is
/// ambiguous.
bool over_a_gap(const PoseHistory& poses) {
  constexpr std::int64_t kLonger =
      3;  // two frames were lost: chosen; one lost now and then is usual
  std::int64_t shortest_ns = INT64_MAX;
  std::int64_t last_ns = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    last_ns = poses[i].timestamp_ns - poses[i - 1].timestamp_ns;
    shortest_ns = std::min(shortest_ns, last_ns);
  }
  return last_ns / kLonger > shortest_ns;
}

Result<RateEstimate> rates_by_pairs(const MotionEstimate& m) {
  const std::size_t count = m.recent.size();
  if (count < 2) {
    return ErrorCode::kTooFewObservations;
  }
  const PoseSample& first = m.recent[count - 2];
  const PoseSample& second = m.recent[count - 1];
  if (over_a_gap(m.recent)) {
    return ErrorCode::kDegenerate;
  }
  const Result<PaperRate> pair = paper_rate(first, second);
  if (!pair) {
    return pair.error();
  }
  RateEstimate rates;
  rates.w_T_rad_s = pair.value().w_T_rad_s;
  rates.covariance_w_T = pair.value().covariance_w_T;
  rates.v_C = pair.value().v_C;
  rates.covariance_v_C = (first.covariance + second.covariance).bottomRightCorner<3, 3>() /
                         (pair.value().interval_s * pair.value().interval_s);
  rates.rotation_poses = rates.position_poses = 2;
  return rates;
}

Result<RateEstimate> rates_by_model(const MotionEstimate& m) {
  const Result<MotionPrediction> now = predict_motion(m.model, m.recent.back().timestamp_ns);
  if (!now || !now.value().translation_known) {
    return ErrorCode::kDegenerate;
  }
  RateEstimate rates;
  rates.w_T_rad_s = now.value().w_T_rad_s;
  rates.covariance_w_T = now.value().covariance_w_T;
  rates.v_C = now.value().v_I;
  rates.covariance_v_C = now.value().covariance_v_I;
  rates.rotation_poses = rates.position_poses = m.model.poses;
  return rates;
}

/// Converts a pose from C to I by the observer's present attitude.
PoseSample in_I(const MotionEstimate& m,
                std::int64_t timestamp_ns,
                const Pose& pose,
                const PoseCovariance& covariance) {
  return {.timestamp_ns = timestamp_ns,
          .pose = turned(m.R_IC, pose),
          .covariance = turned(m.R_IC, covariance)};
}

PoseCovariance drift_I(const MotionEstimate& m, const MapDrift& drift) {
  return turned(m.R_IC, covariance(drift));
}

}  // namespace

std::optional<Eigen::Matrix3d> take_observer(const std::optional<Eigen::Quaterniond>& q_IC,
                                             MotionEstimate* m) {
  constexpr double kNormError = 1e-2;  // of a unit quaternion as it is printed, generously
  if (!q_IC || !(std::abs(q_IC->norm() - 1.0) < kNormError)) {
    return std::nullopt;
  }
  m->R_IC = q_IC->normalized().toRotationMatrix();
  const bool first = !m->observer_known;
  m->observer_known = true;
  if (!first || m->R_IC.isIdentity(0.0)) {
    return std::nullopt;
  }
  for (PoseHistory* const history : {&m->recent, &m->past}) {
    for (PoseSample& sample : *history) {
      sample = turned(m->R_IC, sample);
    }
  }
  replace_model({}, m);
  return m->R_IC;
}

bool remember_pose(std::int64_t timestamp_ns,
                   const Pose& pose,
                   const PoseCovariance& covariance,
                   const MotionOptions& options,
                   MotionEstimate* m) {
  const PoseSample sample = in_I(*m, timestamp_ns, pose, covariance);
  if (!remember(m->recent, sample)) {
    return false;
  }
  ++m->poses_since_start;
  if (options.mode == MotionMode::kPaper) {
    return false;
  }
  (void)remember_for_fit(m->past, sample, options);
  ++m->poses_since_fit;
  return fit_is_due(m->model, m->past.size(), m->poses_since_fit);
}

PoseJudgement check_pose(std::int64_t timestamp_ns,
                         const Pose& pose,
                         const PoseCovariance& covariance,
                         const MapDrift& drift,
                         MotionEstimate* m) {
  return judge_pose(in_I(*m, timestamp_ns, pose, covariance), drift_I(*m, drift), m);
}

void prepare_fit(const Map& map,
                 const MapDrift& drift,
                 const MotionOptions& options,
                 MotionEstimate* m,
                 MotionSnapshot* snapshot) {
  follow_map(map, m->past);
  snapshot->poses = m->past;
  snapshot->drift = drift_I(*m, drift);
  snapshot->body_radius = map.radius_mu;
  snapshot->options = options;
  snapshot->previous = m->model;
  snapshot->known_body = m->known_body;
}

void take_fit(const RigidModel& model,
              std::int64_t fitted_to_ns,
              std::uint32_t poses_fitted,
              const MapDrift& drift,
              MotionEstimate* m) {
  replace_model(model, m);
  m->poses_since_fit -= std::min(m->poses_since_fit, poses_fitted);
  for (const PoseSample& sample : m->recent) {
    if (m->model.accepted() && sample.timestamp_ns > fitted_to_ns) {
      judge_place(sample, drift_I(*m, drift), m);
    }
  }
}

std::optional<DriftByModel> take_joint_fit(const RigidModel& model, MotionEstimate* m) {
  replace_model(model, m);
  m->poses_since_fit = 0;
  const Result<MotionPrediction> now = predict_motion(model, model.reference_ns);
  if (!now || !now.value().translation_known) {
    return std::nullopt;
  }
  return DriftByModel{.covariance_C = turned(m->R_IC.transpose(), now.value().covariance),
                      .relative_speed_sigma = relative_speed_sigma(now.value())};
}

void restate_poses(std::span<const PoseSample> start, MotionEstimate* m) {
  for (PoseHistory* const history : {&m->recent, &m->past}) {
    merge(start, *history);
  }
  replace_model({}, m);
  m->poses_since_fit += static_cast<std::uint32_t>(start.size());
  m->poses_since_start = 0;
}

void move_pose(const Keyframe& keyframe, MotionEstimate* m) {
  for (PoseHistory* const history : {&m->recent, &m->past}) {
    for (PoseSample& sample : *history) {
      if (sample.timestamp_ns == keyframe.timestamp_ns) {
        sample.pose = turned(keyframe.R_IC, keyframe.pose);
      }
    }
  }
}

bool move_poses_with_map(const Map& map, std::int64_t adjusted_to_ns, MotionEstimate* m) {
  bool moved = false;
  for (PoseHistory* const history : {&m->recent, &m->past}) {
    follow_map(map, *history);
    moved = moved || (!history->empty() && history->back().timestamp_ns > adjusted_to_ns);
  }
  return moved;
}

void reset_poses(MotionEstimate* m) {
  m->recent.clear();
  m->past.clear();
  replace_model({}, m);
  m->poses_since_fit = m->poses_since_start = 0;
  m->moves_so_since_ns = INT64_MIN;
  m->known_body = {};
  forget_seen(m);
}

Result<RateEstimate> rates_now(const MotionEstimate& m,
                               const MapDrift& drift,
                               const MotionOptions& options) {
  Result<RateEstimate> rates = ErrorCode::kTooFewObservations;
  if (m.repeats > 0) {
    return rates;  // no pose of this time is measured, or the body has stopped
  }
  if (options.mode == MotionMode::kPaper) {
    rates = rates_by_pairs(m);
  } else if (m.departures > 0) {
    return rates;  // either an outlier or a disturbance: neither rate is certain
  } else if (holds(m)) {
    rates = rates_by_model(m);
  }
  if (!rates && options.mode != MotionMode::kPaper) {
    rates = estimate_rates(m.recent.view(), options);
    if (rates) {
      widen_by_drift(drift_I(m, drift), turn_sigma(drift), rates.value());
    }
  }
  if (rates) {
    rates.value().v_C = m.R_IC.transpose() * rates.value().v_C;
    rates.value().covariance_v_C = m.R_IC.transpose() * rates.value().covariance_v_C * m.R_IC;
  }
  return rates;
}

Result<PosePrediction> predict_by_motion(const MotionEstimate& m,
                                         const MapDrift& drift,
                                         const MotionOptions& options,
                                         std::int64_t timestamp_ns,
                                         const Eigen::Matrix3d& R_IC) {
  Result<PosePrediction> predicted =
      predict_after(led_to(m), m, drift_I(m, drift), options, timestamp_ns);
  if (predicted) {
    predicted.value() = turned(R_IC.transpose(), predicted.value());
  }
  return predicted;
}

std::optional<ExpectedPose> expected_from_departed(const MotionEstimate& m,
                                                   const MapDrift& drift,
                                                   const MotionOptions& options,
                                                   std::int64_t timestamp_ns) {
  if (m.departures == 0 || m.recent.empty()) {
    return std::nullopt;
  }
  const Result<PosePrediction> predicted =
      predict_after(m.recent.view(), m, drift_I(m, drift), options, timestamp_ns);
  if (!predicted) {
    return std::nullopt;
  }
  return ExpectedPose{
      .prediction = turned(m.R_IC.transpose(), predicted.value()),
      .step_rad = rotation_angle_rad(m.recent.back().pose.R_CT, predicted.value().pose.R_CT),
      .poses_since_start = m.poses_since_start};
}

Pose last_pose_seen(const MotionEstimate& m, const Eigen::Matrix3d& R_IC) {
  return turned(R_IC.transpose(), m.recent.back().pose);
}

std::optional<PosePrediction> predict_or_hold(const MotionEstimate& m,
                                              const MapDrift& drift,
                                              const MotionOptions& options,
                                              std::int64_t timestamp_ns,
                                              const Eigen::Matrix3d& R_IC) {
  if (m.recent.empty()) {
    return std::nullopt;
  }
  const Pose last = last_pose_seen(m, R_IC);
  const Result<PosePrediction> by_motion = predict_by_motion(m, drift, options, timestamp_ns, R_IC);
  PosePrediction predicted = by_motion ? by_motion.value() : PosePrediction{.pose = last};
  // Extrapolated through the camera: the last position is the better estimate.
  if (!(predicted.pose.p_CT.z() > 0.1 * last.p_CT.z())) {
    predicted.pose.p_CT = last.p_CT;
  }
  return predicted;
}

ExpectedPose expected_at(const PosePrediction& predicted,
                         std::int64_t timestamp_ns,
                         const MotionEstimate& m) {
  const std::span<const PoseSample> poses = led_to(m);
  double step_rad = 0.0;
  if (!poses.empty()) {
    const PoseSample& from = poses.back();
    step_rad = rotation_angle_rad(m.R_IC.transpose() * from.pose.R_CT, predicted.pose.R_CT);
    if (seconds_between(from.timestamp_ns, timestamp_ns) > unambiguous_interval_max_s(poses)) {
      step_rad = std::numbers::pi;  // the number of turns is ambiguous
    }
  }
  return {.prediction = predicted, .step_rad = step_rad, .poses_since_start = m.poses_since_start};
}

std::optional<PosePrediction> pose_by_joint_model(const MotionEstimate& m,
                                                  const MotionOptions& options,
                                                  std::int64_t timestamp_ns,
                                                  const Eigen::Matrix3d& R_IC) {
  if (!m.model.of_map || !holds(m) || options.mode == MotionMode::kPaper) {
    return std::nullopt;
  }
  const Result<MotionPrediction> at = predict_motion(m.model, timestamp_ns);
  if (!at || !at.value().translation_known) {
    return std::nullopt;
  }
  return PosePrediction{.pose = turned(R_IC.transpose(), at.value().pose),
                        .covariance = turned(R_IC.transpose(), at.value().covariance),
                        .rotation_poses = m.model.poses,
                        .position_poses = m.model.poses};
}

}  // namespace polhode
