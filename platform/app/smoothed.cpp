#include "app/smoothed.hpp"

#include "geometry/so3.hpp"
#include "pipeline/mapping.hpp"
#include "pipeline/publish.hpp"
#include "pipeline/state.hpp"

namespace polhode::platform {
namespace {

PoseSample in_body(const AbsolutePose& absolute,
                   std::int64_t timestamp_ns,
                   const BodyFrame& body,
                   double unit) {
  const Pose pose = scaled(absolute.pose, unit);
  const Eigen::Vector3d arm_C = pose.R_CT * body.centroid_T;
  PoseCovariance by_T = PoseCovariance::Identity();  // (phi, dp) of B's origin by that of T's
  by_T.bottomLeftCorner<3, 3>() = -hat(arm_C);
  return {.timestamp_ns = timestamp_ns,
          .pose = {.R_CT = pose.R_CT * body.R_TB, .p_CT = pose.p_CT + arm_C},
          .covariance = by_T * scaled(absolute.covariance, unit) * by_T.transpose()};
}

/// Rates at a sample: by the model where it holds, else by local fits from both sides. Velocity in I.
Result<RateEstimate> rates_at(std::span<const PoseSample> samples,
                              std::size_t index,
                              const PoseCovariance& drift,
                              RigidModel& model,
                              const MotionOptions& options) {
  const bool within = model.accepted() && model.path_known;
  if (within && move_reference(samples[index].timestamp_ns, model)) {
    const Result<MotionPrediction> at = predict_motion(model, samples[index].timestamp_ns);
    if (at) {
      RateEstimate rates;
      rates.w_T_rad_s = at.value().w_T_rad_s;
      rates.covariance_w_T = at.value().covariance_w_T;
      rates.v_C = at.value().v_I;
      rates.covariance_v_C = at.value().covariance_v_I;
      return rates;
    }
  }
  Result<RateEstimate> local = estimate_rates_at(samples, index, options);
  if (local) {
    widen_by_drift(drift, local.value());
  }
  return local;
}

}  // namespace

std::vector<PoseSample> samples_in_body(const std::vector<SmoothedPose>& poses,
                                        std::span<const MotionState> published,
                                        const BodyFrame& body,
                                        double metres_per_mu,
                                        const ServicerAttitude& servicer) {
  std::vector<PoseSample> samples;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::int64_t timestamp_ns = published[i].timestamp_ns;
    const bool later = samples.empty() || timestamp_ns > samples.back().timestamp_ns;
    if (poses[i].valid && later) {
      samples.push_back(turned(servicer.R_IC(timestamp_ns),
                               in_body(poses[i].absolute, timestamp_ns, body, metres_per_mu)));
    }
  }
  return samples;
}

PoseCovariance drift_at_rest(const Component::State& state) {
  MapDrift held = state.drift;
  hold_at_both_ends(&held);
  return scaled(covariance(held), state.scale.metres_per_mu);
}

RigidModel model_of(std::span<const PoseSample> samples,
                    double body_radius,
                    const Component::State& state) {
  if (state.parameters.motion.mode == MotionMode::kPaper || samples.empty()) {
    return {};
  }
  auto snapshot = std::make_unique<MotionSnapshot>();
  auto workspace = std::make_unique<MotionWorkspace>();
  const std::size_t every = 1 + (samples.size() - 1) / PoseHistory::capacity();
  // The last one is always among them.
  for (std::size_t i = (samples.size() - 1) % every; i < samples.size(); i += every) {
    (void)snapshot->poses.push_back(samples[i]);
  }
  snapshot->drift = drift_at_rest(state);
  snapshot->body_radius = body_radius > 0.0 ? body_radius : 1.0;
  snapshot->options = state.parameters.motion;
  return fit_rigid_model(*snapshot, *workspace);
}

std::vector<MotionState> smoothed_motion(const std::vector<SmoothedPose>& poses,
                                         const std::vector<PoseSample>& samples,
                                         std::span<const MotionState> published,
                                         const RigidModel& model,
                                         const ServicerAttitude& servicer,
                                         const Component::State& state) {
  std::vector<MotionState> smoothed;
  std::array<double, 4> q_last{1.0, 0.0, 0.0, 0.0};
  std::size_t next = 0;
  RigidModel moving = model;
  const std::int64_t held_from_ns =
      model.reference_ns - static_cast<std::int64_t>(1e9 * model.span_s) - 1;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    MotionState m;
    m.frame = published[i].frame;
    m.timestamp_ns = published[i].timestamp_ns;
    m.scale_known = state.scale.known;
    m.mode = poses[i].valid ? Mode::kTracking : published[i].mode;
    m.features = published[i].features;
    m.landmarks = static_cast<std::uint16_t>(state.map.landmark_count);
    m.keyframes = static_cast<std::uint16_t>(state.map.keyframe_count);
    if (next < samples.size() && poses[i].valid && samples[next].timestamp_ns == m.timestamp_ns) {
      m.matches = static_cast<std::uint16_t>(poses[i].matches);
      m.inliers = static_cast<std::uint16_t>(poses[i].absolute.inliers);
      const Eigen::Matrix3d R_CI = servicer.R_IC(m.timestamp_ns).transpose();
      const PoseSample in_C = turned(R_CI, samples[next]);
      fill_pose(in_C.pose, in_C.covariance + drift_at_rest(state), &q_last, &m);
      RigidModel none;
      auto rates = rates_at(samples,
                            next,
                            drift_at_rest(state),
                            m.timestamp_ns >= held_from_ns ? moving : none,
                            state.parameters.motion);
      if (rates) {
        rates.value().v_C = R_CI * rates.value().v_C;
        rates.value().covariance_v_C = R_CI * rates.value().covariance_v_C * R_CI.transpose();
        publish(rates.value(), m);
      }
      ++next;
    }
    smoothed.push_back(m);
  }
  return smoothed;
}

}  // namespace polhode::platform
