#include "motion/disturbance.hpp"

#include <optional>

#include "geometry/so3.hpp"
#include "motion/rates.hpp"

namespace polhode {
namespace {

// 99.9 % of chi-square with six degrees of freedom; sigmas of single poses are right to a factor of
// two.
constexpr double kChi2Max = 4.0 * 22.5;
constexpr std::uint32_t kDisagreementsMax = 3;
// Twice 99.9 %: over so short a time most errors are common to both poses. On free bodies one pose
// in a hundred is inconsistent (decision 0070).
constexpr double kChi2DepartsMax = 2.0 * 22.5;
// One may be an outlier. Two in succession are a contact, or an unreported manoeuvre.
constexpr std::uint32_t kDeparturesMax = 2;
// Repeats of one image in succession; after more of them the body has stopped. Chosen: a transfer
// that is retried gives two or three.
constexpr std::uint32_t kRepeatsMax = 5;
// A model counts as validated after it predicted as many poses as its rotation has unknowns.
constexpr std::uint32_t kLedToMin = kRotationUnknowns;

/// Is the pose inconsistent with the motion predicted from the last consistent one? This shows a
/// change of the rate at once: the map's drift and the model's phase error cancel.
/// @return nothing without a prediction, or where the number of turns over the interval is
/// ambiguous.
std::optional<bool> departs(const PoseSample& sample,
                            const PoseCovariance& drift_I,
                            const MotionEstimate& m) {
  if (m.recent.size() <= m.departures) {
    return std::nullopt;
  }
  const PoseSample& from = m.recent[m.recent.size() - 1 - m.departures];
  if (seconds_between(from.timestamp_ns, sample.timestamp_ns) >
      unambiguous_interval_max_s(m.recent.view())) {
    return std::nullopt;
  }
  const Result<MotionPrediction> at = predict_on(m.model, from, drift_I, sample.timestamp_ns);
  if (!at) {
    return std::nullopt;
  }
  return !(chi2_between(at.value(), sample) <= kChi2DepartsMax);  // true for a NaN
}

/// chi2 of the hypothesis that two poses are equal. In C: a repeated image has the same pose there,
/// even if the observer has rotated.
double chi2_of_same(const PoseSample& a, const PoseSample& b) {
  return chi2_between({.pose = b.pose, .covariance = b.covariance, .translation_known = true}, a);
}

/// Removes the previous pose if it was inconsistent: this one is consistent, so that was an
/// outlier.
/// @return the time of the removed pose.
std::optional<std::int64_t> forget_departed(MotionEstimate* m) {
  static_assert(kDeparturesMax == 2, "of two, one is left to forget");
  if (m->departures == 0) {
    return std::nullopt;
  }
  m->departures = 0;
  const std::int64_t wrong_ns = m->recent.back().timestamp_ns;
  for (PoseHistory* const history : {&m->recent, &m->past}) {
    if (!history->empty() && history->back().timestamp_ns == wrong_ns) {
      history->resize(history->size() - 1);
    }
  }
  return wrong_ns;
}

/// A disturbance before the first inconsistent pose: drops all poses before that one. The last
/// inconsistent pose is not stored yet.
void begin_anew(MotionEstimate* m) {
  const std::size_t kept = m->departures - 1;
  const std::int64_t since_ns = m->recent[m->recent.size() - kept].timestamp_ns;
  for (PoseHistory* const history : {&m->recent, &m->past}) {
    while (!history->empty() && (*history)[0].timestamp_ns < since_ns) {
      history->erase(0);
    }
  }
  refute_model(m);
  m->moves_so_since_ns = since_ns;
  m->poses_since_fit = static_cast<std::uint32_t>(kept);
  m->poses_since_start = static_cast<std::uint32_t>(kept);
}

}  // namespace

bool repeats_last(const PoseSample& seen_C, MotionEstimate* m) {
  // Part of the rotation expected at the last rate. Noise rarely hides nine tenths of a significant
  // rotation (kChi2Max).
  constexpr double kPart = 0.1;
  double chi2 = 0.0;
  double step_rad = 0.0;
  double interval_s = 0.0;
  if (m->last_seen.any) {
    chi2 = chi2_of_same(seen_C, m->last_seen.pose_C);
    step_rad = rotation_angle_rad(seen_C.pose.R_CT, m->last_seen.pose_C.pose.R_CT);
    interval_s = seconds_between(m->last_seen.pose_C.timestamp_ns, seen_C.timestamp_ns);
  }
  if (m->repeats < kRepeatsMax && chi2 < kChi2Max &&
      step_rad < kPart * m->last_seen.moved_rad_s * interval_s) {
    ++m->repeats;
    return true;
  }
  m->last_seen.moved_rad_s = chi2 > kChi2Max && interval_s > 0.0 ? step_rad / interval_s : 0.0;
  m->repeats = 0;
  m->last_seen.any = true;
  m->last_seen.pose_C = seen_C;
  return false;
}

void judge_place(const PoseSample& sample, const PoseCovariance& drift_I, MotionEstimate* m) {
  const Result<double> chi2 = chi2_against(m->model, sample, drift_I);
  m->disagreements = chi2 && chi2.value() > kChi2Max ? m->disagreements + 1 : 0;
  if (m->disagreements >= kDisagreementsMax) {
    m->model.status = ModelStatus::kResidualsTooLarge;
    m->departures = 0;
    m->led_to = 0;
  }
}

void pass_over_pose(MotionEstimate* m) { m->departures = 0; }

void move_seen(const Pose& pose_C, MotionEstimate* m) { m->last_seen.pose_C.pose = pose_C; }

void forget_seen(MotionEstimate* m) {
  m->last_seen.any = false;
  m->last_seen.moved_rad_s = 0.0;
  m->repeats = 0;
}

void replace_model(const RigidModel& model, MotionEstimate* m) {
  if (!m->model.accepted() || !model.accepted()) {
    m->departures = 0;
    m->led_to = 0;
  }
  m->model = model;
  m->disagreements = 0;
}

void refute_model(MotionEstimate* m) {
  replace_model({}, m);
  m->model.status = ModelStatus::kResidualsTooLarge;
}

PoseJudgement judge_pose(const PoseSample& sample,
                         const PoseCovariance& drift_I,
                         MotionEstimate* m) {
  PoseJudgement judgement;
  if (!m->model.accepted()) {
    return judgement;
  }
  const std::optional<bool> gone = departs(sample, drift_I, *m);
  if (!gone) {
    pass_over_pose(m);
  } else if (*gone) {
    ++m->departures;
  } else {
    judgement.withdrawn_ns = forget_departed(m);
    ++m->led_to;
  }
  if (m->departures >= kDeparturesMax) {
    if (m->led_to < kLedToMin) {
      refute_model(m);
      return judgement;
    }
    begin_anew(m);
    judgement.begun_anew = true;
    return judgement;
  }
  if (m->departures == 0) {
    judge_place(sample, drift_I, m);
  }
  return judgement;
}

}  // namespace polhode
