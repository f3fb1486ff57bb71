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

}  // namespace

std::vector<PoseSample> samples_in_body(const std::vector<SmoothedPose>& poses,
                                        std::span<const MotionState> published,
                                        const BodyFrame& body,
                                        double metres_per_mu) {
  std::vector<PoseSample> samples;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::int64_t timestamp_ns = published[i].timestamp_ns;
    const bool later = samples.empty() || timestamp_ns > samples.back().timestamp_ns;
    if (poses[i].valid && later) {
      samples.push_back(in_body(poses[i].absolute, timestamp_ns, body, metres_per_mu));
    }
  }
  return samples;
}

std::vector<MotionState> smoothed_motion(const std::vector<SmoothedPose>& poses,
                                         const std::vector<PoseSample>& samples,
                                         std::span<const MotionState> published,
                                         const Component::State& state) {
  std::vector<MotionState> smoothed;
  std::array<double, 4> q_last{1.0, 0.0, 0.0, 0.0};
  std::size_t next = 0;
  MapDrift held = state.drift;
  hold_at_both_ends(&held);
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
      const PoseCovariance drift = scaled(covariance(held), state.scale.metres_per_mu);
      fill_pose(samples[next].pose, samples[next].covariance + drift, &q_last, &m);
      if (const auto rates = estimate_rates_at(samples, next, state.parameters.motion)) {
        publish(rates.value(), m);
      }
      ++next;
    }
    smoothed.push_back(m);
  }
  return smoothed;
}

}  // namespace polhode::platform
