#include "pipeline/motion_now.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/so3.hpp"
#include "motion/fit_poses.hpp"
#include "motion/paper.hpp"
#include "motion/residual_level.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

// 99.9 % of chi-square with six degrees of freedom; sigmas of single poses are right to a factor of
// two.
constexpr double kChi2Max = 4.0 * 22.5;
constexpr std::uint32_t kDisagreementsMax = 3;

bool holds(const MotionNow& m) {
  return m.model.accepted() && m.disagreements < kDisagreementsMax;
}

const Keyframe* keyframe_at(std::int64_t timestamp_ns, const Map& map) {
  const auto found = std::find_if(map.keyframes.begin(), map.keyframes.end(), [&](const Keyframe& k) {
    return k.used && k.timestamp_ns == timestamp_ns;
  });
  return found == map.keyframes.end() ? nullptr : &*found;
}

/// Adjustments move keyframes after their poses were remembered, and the poses since then with them.
void follow_map(const Map& map, PoseHistory& poses) {
  Pose from;  // what the last keyframe's pose was, and is
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

void ask_for_fit(Component::State* s) {
  MotionNow& m = s->motion;
  follow_map(s->map, m.past);
  FitJob& job = s->fit_job;
  job.snapshot.poses = m.past;
  job.snapshot.drift = turned(m.R_IC, polhode::covariance(s->drift));
  job.snapshot.body_radius = s->map.radius_mu;
  job.snapshot.options = s->parameters.motion;
  job.snapshot.previous = m.model;
  job.poses_new = m.poses_since_fit;
  issue_fit(s);
}

void check(const PoseSample& sample, const PoseCovariance& drift_I, MotionNow* m) {
  const Result<double> chi2 = chi2_against(m->model, sample, drift_I);
  m->disagreements = chi2 && chi2.value() > kChi2Max ? m->disagreements + 1 : 0;
  if (m->disagreements >= kDisagreementsMax) {
    m->model.status = ModelStatus::kResidualsTooLarge;
  }
}

/// Both in order of time; where they meet the new one stays, and a full table loses its oldest.
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
    (void)remember(history, old[next]);  // refuses what a new one has replaced
  }
}

/// 1-sigma of the angular speed, as a part of it; 1 of what does not turn.
double relative_speed_sigma(const MotionPrediction& now) {
  const Eigen::Vector3d& w = now.w_T_rad_s;
  const double sigma = std::sqrt(std::max(0.0, w.dot(now.covariance_w_T * w)));
  return sigma < w.squaredNorm() ? sigma / w.squaredNorm() : 1.0;
}

/// Is the last interval far longer than the shortest? Over it a body may have turned by any number of turns.
bool over_a_gap(const PoseHistory& poses) {
  constexpr std::int64_t kLonger = 3;
  std::int64_t shortest_ns = INT64_MAX;
  std::int64_t last_ns = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    last_ns = poses[i].timestamp_ns - poses[i - 1].timestamp_ns;
    shortest_ns = std::min(shortest_ns, last_ns);
  }
  return last_ns / kLonger > shortest_ns;
}

Result<RateEstimate> rates_by_pairs(const MotionNow& m) {
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

Result<RateEstimate> rates_by_model(const MotionNow& m) {
  const Result<MotionPrediction> now = predict_motion(m.model, m.recent.back().timestamp_ns);
  if (!now || !now.value().path_known) {
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

std::optional<Eigen::Quaterniond> told_attitude(const StepInput& input,
                                                const ServicerAttitude& servicer) {
  if (input.q_IC) {
    const std::array<double, 4>& q = *input.q_IC;
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  }
  if (!servicer.known) {
    return std::nullopt;
  }
  const double since_s =
      1e-9 * static_cast<double>(input.frame.timestamp_ns - servicer.timestamp_ns);
  return servicer.q_IC * Eigen::Quaterniond(so3_exp(since_s * servicer.w_C_rad_s));
}

/// All that is remembered, from I as it was taken to be into I as it is.
void turn_past(const Eigen::Matrix3d& R, Component::State* s) {
  if (R.isIdentity(0.0)) {
    return;
  }
  for (Keyframe& keyframe : s->map.keyframes) {
    keyframe.R_IC = R * keyframe.R_IC;
  }
  for (CollectedFrame& frame : s->tracks.frames) {
    frame.R_IC = R * frame.R_IC;
  }
  for (PoseHistory* const history : {&s->motion.recent, &s->motion.past}) {
    for (PoseSample& sample : *history) {
      sample = turned(R, sample);
    }
  }
  forsake_model(s);
}

}  // namespace

void forsake_model(Component::State* s) {
  s->motion.model = {};
  s->fit_job.unwanted = true;
  s->job.adjustment.model_unwanted = true;
}

void set_observer(const StepInput& input, Component::State* s) {
  const std::optional<Eigen::Quaterniond> q_IC = told_attitude(input, s->bus.servicer);
  constexpr double kNormError = 1e-2;  // of a printed or single-precision unit quaternion, generously
  if (!q_IC || !(std::abs(q_IC->norm() - 1.0) < kNormError)) {
    return;
  }
  MotionNow& m = s->motion;
  m.R_IC = q_IC->normalized().toRotationMatrix();
  if (!m.observer_known) {
    m.observer_known = true;
    turn_past(m.R_IC, s);
  }
}

void remember_motion(std::int64_t timestamp_ns,
                     const Pose& pose,
                     const PoseCovariance& covariance,
                     Component::State* s) {
  MotionNow& m = s->motion;
  const PoseSample sample{.timestamp_ns = timestamp_ns,
                          .pose = turned(m.R_IC, pose),
                          .covariance = turned(m.R_IC, covariance)};
  if (!remember(m.recent, sample)) {
    return;
  }
  ++m.poses_since_start;
  if (s->parameters.motion.mode == MotionMode::kPaper) {
    return;
  }
  (void)remember_for_fit(m.past, sample, s->parameters.motion);
  ++m.poses_since_fit;
  if (fit_slot_free(*s) && fit_is_due(m.model, m.past.size(), m.poses_since_fit)) {
    ask_for_fit(s);
  }
}

void check_motion(std::int64_t timestamp_ns,
                  const Pose& pose,
                  const PoseCovariance& covariance,
                  Component::State* s) {
  MotionNow& m = s->motion;
  if (m.model.accepted()) {
    const PoseSample measured{.timestamp_ns = timestamp_ns,
                              .pose = turned(m.R_IC, pose),
                              .covariance = turned(m.R_IC, covariance)};
    check(measured, turned(m.R_IC, polhode::covariance(s->drift)), &m);
  }
}

std::optional<PosePrediction> pose_by_map_model(const Component::State& s,
                                                std::int64_t timestamp_ns,
                                                const Eigen::Matrix3d& R_IC) {
  const MotionNow& m = s.motion;
  if (!m.model.of_map || !holds(m) || s.parameters.motion.mode == MotionMode::kPaper) {
    return std::nullopt;
  }
  const Result<MotionPrediction> at = predict_motion(m.model, timestamp_ns);
  if (!at || !at.value().path_known) {
    return std::nullopt;
  }
  return PosePrediction{.pose = turned(R_IC.transpose(), at.value().pose),
                        .covariance = turned(R_IC.transpose(), at.value().covariance),
                        .rotation_poses = m.model.poses,
                        .position_poses = m.model.poses};
}

void take_fit(Component::State* s) {
  MotionNow& m = s->motion;
  const FitJob& job = s->fit_job;
  if (job.skipped) {
    return;
  }
  m.model = job.model;
  m.poses_since_fit -= std::min(m.poses_since_fit, job.poses_new);
  m.disagreements = 0;
  const std::int64_t fitted_to_ns = job.snapshot.poses.back().timestamp_ns;
  for (const PoseSample& sample : m.recent) {
    if (m.model.accepted() && sample.timestamp_ns > fitted_to_ns) {
      check(sample, turned(m.R_IC, polhode::covariance(s->drift)), &m);
    }
  }
}

void take_joint_fit(const RigidModel& model, Component::State* s) {
  MotionNow& m = s->motion;
  m.model = model;
  m.poses_since_fit = 0;
  m.disagreements = 0;
  s->fit_job.unwanted = true;
  const Result<MotionPrediction> now = predict_motion(model, model.reference_ns);
  if (now && now.value().path_known) {
    replace_walk(turned(m.R_IC.transpose(), now.value().covariance), &s->drift);
    hold_turn(relative_speed_sigma(now.value()), s->map.radius_mu, &s->drift);
  }
}

void restate_motion(std::span<const PoseSample> start, Component::State* s) {
  MotionNow& m = s->motion;
  for (PoseHistory* const history : {&m.recent, &m.past}) {
    merge(start, *history);
  }
  forsake_model(s);
  m.poses_since_fit += static_cast<std::uint32_t>(start.size());
  m.poses_since_start = 0;
}

void move_pose(const Keyframe& keyframe, Component::State* s) {
  for (PoseHistory* const history : {&s->motion.recent, &s->motion.past}) {
    for (PoseSample& sample : *history) {
      if (sample.timestamp_ns == keyframe.timestamp_ns) {
        sample.pose = turned(keyframe.R_IC, keyframe.pose);
      }
    }
  }
}

bool move_poses_with_map(std::int64_t adjusted_to_ns, Component::State* s) {
  bool moved = false;
  for (PoseHistory* const history : {&s->motion.recent, &s->motion.past}) {
    follow_map(s->map, *history);
    moved = moved || (!history->empty() && history->back().timestamp_ns > adjusted_to_ns);
  }
  return moved;
}

void forget_motion(Component::State* s) {
  MotionNow& m = s->motion;
  m.recent.clear();
  m.past.clear();
  forsake_model(s);
  m.poses_since_fit = 0;
  m.poses_since_start = 0;
  m.disagreements = 0;
  s->ahead.walk.under_way = false;
}

Result<RateEstimate> rates_now(const Component::State& s) {
  const MotionNow& m = s.motion;
  Result<RateEstimate> rates = ErrorCode::kTooFewObservations;
  if (s.parameters.motion.mode == MotionMode::kPaper) {
    rates = rates_by_pairs(m);
  } else if (holds(m)) {
    rates = rates_by_model(m);
  }
  if (!rates && s.parameters.motion.mode != MotionMode::kPaper) {
    rates = estimate_rates(m.recent.view(), s.parameters.motion);
    if (rates) {
      widen_by_drift(
          turned(m.R_IC, polhode::covariance(s.drift)), turn_sigma(s.drift), rates.value());
    }
  }
  if (rates) {
    rates.value().v_C = m.R_IC.transpose() * rates.value().v_C;
    rates.value().covariance_v_C =
        m.R_IC.transpose() * rates.value().covariance_v_C * m.R_IC;
  }
  return rates;
}

Result<PosePrediction> predict_by_motion(const Component::State& s,
                                         std::int64_t timestamp_ns,
                                         const Eigen::Matrix3d& R_IC) {
  const MotionNow& m = s.motion;
  Result<PosePrediction> predicted = ErrorCode::kTooFewObservations;
  if (!m.recent.empty() && holds(m) && s.parameters.motion.mode == MotionMode::kDynamics) {
    const Result<MotionPrediction> by_model = predict_from(m.model, m.recent.back(), timestamp_ns);
    if (by_model && by_model.value().path_known) {
      // The next pose will be one of the map: its drift changes while the body turns.
      const double part = rotation_angle_rad(m.recent.back().pose.R_CT, by_model.value().pose.R_CT) /
                          kSideAngle_rad;
      predicted = PosePrediction{.pose = by_model.value().pose,
                                 .covariance = by_model.value().covariance +
                                               part * part * turned(m.R_IC, polhode::covariance(s.drift)),
                                 .rotation_poses = m.model.poses,
                                 .position_poses = m.model.poses};
    }
  }
  if (!predicted) {
    predicted = predict_pose(m.recent.view(), timestamp_ns, s.parameters.motion);
  }
  if (predicted) {
    predicted.value().pose = turned(R_IC.transpose(), predicted.value().pose);
    predicted.value().covariance = turned(R_IC.transpose(), predicted.value().covariance);
  }
  return predicted;
}

Pose last_pose_seen(const Component::State& s, const Eigen::Matrix3d& R_IC) {
  return turned(R_IC.transpose(), s.motion.recent.back().pose);
}

}  // namespace polhode
