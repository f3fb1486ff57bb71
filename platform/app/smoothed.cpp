#include "app/smoothed.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "geometry/so3.hpp"
#include "map/drift.hpp"
#include "map/map.hpp"
#include "map/track.hpp"
#include "motion/joint_fit.hpp"
#include "motion/published.hpp"
#include "motion/stamp_doubt.hpp"
#include "shape/scale_state.hpp"
#include "solve/camera_verdict.hpp"

namespace polhode::platform {
namespace {

// A model answers for its own poses' time and for a tenth of it on either side, as long as it is
// surer than this: frames beyond that stay empty.
constexpr double kBeyond = 0.1;
constexpr double kAttitudeSigmaMax_rad = 0.0873;  // 5 deg

// Poses are the model's where hardly any measured one lies far from it. Photographs that claim
// times they were not taken at have one in four there, rendered sequences one in thirty at most.
constexpr double kOutliersMax = 0.05;
constexpr double kChi2PerDofMax = 1.4;

bool goes_through_poses(const RigidModel& model) {
  const auto few = static_cast<std::size_t>(kOutliersMax * static_cast<double>(model.poses));
  if (model.of_map) {
    return model.accepted();  // they are its own
  }
  return model.accepted() && model.translation_known && model.attitude.outliers <= few &&
         model.position.outliers <= few && model.position.chi2_per_dof < kChi2PerDofMax;
}

/// The run's model on its way through the frames.
struct ModelOfRun {
  RigidModel model;  ///< its reference is the last requested time
  bool with_poses = false;
  std::int64_t from_ns = 0;
  std::int64_t to_ns = 0;
};

/// Time of the last pose by an earlier map, in another frame T: the present motion may not be
/// extrapolated back over the break between the maps.
std::int64_t end_of_map_before(std::span<const MotionState> published,
                               std::uint32_t target_frame,
                               std::int64_t first_pose_ns) {
  const auto last = std::find_if(published.rbegin(), published.rend(), [&](const MotionState& m) {
    return m.pose_valid && m.target_frame != target_frame && m.timestamp_ns < first_pose_ns;
  });
  return last == published.rend() ? std::numeric_limits<std::int64_t>::min() : last->timestamp_ns;
}

ModelOfRun of_run(const RigidModel& model,
                  std::span<const MotionState> published,
                  const GroundView& view) {
  const auto span_ns = static_cast<std::int64_t>(1e9 * model.span_s);
  const std::int64_t first_pose_ns = model.reference_ns - span_ns;
  const auto beyond_ns = static_cast<std::int64_t>(kBeyond * 1e9 * model.span_s);
  return {.model = model,
          .with_poses = goes_through_poses(model),
          .from_ns = std::max({first_pose_ns - beyond_ns,
                               view.moves_so_since_ns,  // before that the body moved otherwise
                               end_of_map_before(published, view.target_frame, first_pose_ns) + 1}),
          .to_ns = model.reference_ns + beyond_ns};
}

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

/// The motion at one frame, in I.
struct AtFrame {
  std::optional<PoseSample> pose;  ///< with the error that poses of one side share
  std::optional<RateEstimate> rates;
};

/// By the model, where it may answer. It holds every measured pose with its weight already: a
/// measured one beside it would count twice. The run's model is moved on, so that a run costs one
/// integration.
AtFrame by_model(std::int64_t timestamp_ns, ModelOfRun* run) {
  if (!run->model.accepted() || !run->model.translation_known || timestamp_ns < run->from_ns ||
      timestamp_ns > run->to_ns || !move_reference(timestamp_ns, run->model)) {
    return {};
  }
  const Result<MotionPrediction> found = predict_motion(run->model, timestamp_ns);
  if (!found ||
      worst_sigma(found.value().covariance.topLeftCorner<3, 3>()) > kAttitudeSigmaMax_rad) {
    return {};
  }
  const MotionPrediction& at = found.value();
  RateEstimate rates;
  rates.w_T_rad_s = at.w_T_rad_s;
  rates.covariance_w_T = at.covariance_w_T;
  rates.v_C = at.v_I;
  rates.covariance_v_C = at.covariance_v_I;
  AtFrame by_model{.pose = std::nullopt, .rates = rates};
  if (run->with_poses) {
    by_model.pose =
        PoseSample{.timestamp_ns = timestamp_ns, .pose = at.pose, .covariance = at.covariance};
  }
  return by_model;
}

/// The samples before a disturbance, or those after it.
struct Side {
  std::span<const PoseSample> samples;
  std::size_t index = 0;
};

/// How many of the last samples are not before a time.
std::size_t samples_since(std::span<const PoseSample> samples, std::int64_t since_ns) {
  return static_cast<std::size_t>(
      std::count_if(samples.begin(), samples.end(), [&](const PoseSample& sample) {
        return sample.timestamp_ns >= since_ns;
      }));
}

Side side_of(std::span<const PoseSample> samples, std::size_t index, std::int64_t disturbed_ns) {
  const std::size_t before = samples.size() - samples_since(samples, disturbed_ns);
  return index < before ? Side{.samples = samples.first(before), .index = index}
                        : Side{.samples = samples.subspan(before), .index = index - before};
}

/// The measured pose; where the model has no rates, those of a fit to poses on both sides.
AtFrame by_measurement(const Side& side,
                       const PoseCovariance& drift,
                       const MotionOptions& options,
                       const std::optional<RateEstimate>& rates_by_model) {
  AtFrame at{.pose = side.samples[side.index], .rates = rates_by_model};
  at.pose->covariance += drift;
  if (rates_by_model) {
    return at;
  }
  Result<RateEstimate> local = estimate_rates_at(side.samples, side.index, options);
  if (local) {
    widen_by_drift(drift, 0.0, local.value());  // the converged map has seen the whole turn
    at.rates = local.value();
  }
  return at;
}

/// @param next  the sample that comes after the frame's own
bool times_are_contradicted(std::span<const PoseSample> samples, std::size_t next) {
  return !samples.empty() && doubt_of_stamps_about(samples, next > 0 ? next - 1 : 0).contradicted;
}

MotionState row_of(const MotionState& published, const SmoothedPose& pose, const GroundView& view) {
  MotionState m;
  m.frame = published.frame;
  m.timestamp_ns = published.timestamp_ns;
  m.scale_known = view.scale.known;
  m.scale_number = view.scale_number;
  m.metres_per_mu = view.scale.metres_per_mu;
  m.target_frame = view.target_frame;
  // A predicted pose is none of the smoothed ones.
  const bool tracks = pose.valid || published.mode == Mode::kCoasting;
  m.mode = tracks ? Mode::kTracking : published.mode;
  m.features = published.features;
  m.landmarks = static_cast<std::uint16_t>(view.map.landmark_count);
  m.keyframes = static_cast<std::uint16_t>(view.map.keyframe_count);
  return m;
}

void write_motion(const AtFrame& at,
                  const Eigen::Matrix3d& R_CI,
                  const GroundView& view,
                  std::array<double, 4>* q_last,
                  MotionState* m) {
  PoseSample in_C = turned(R_CI, *at.pose);
  const double range = in_C.pose.p_CT.norm();
  const CameraError camera =
      error_by(view.camera_found, view.map.radius_mu * view.scale.metres_per_mu / range);
  widen(camera, range, &in_C.covariance);
  const double scale_sigma = std::hypot(view.scale.relative_sigma, camera.along);
  fill_pose(in_C.pose, in_C.covariance + by_scale(in_C.pose, scale_sigma), q_last, m);
  if (at.rates) {
    RateEstimate rates = *at.rates;
    rates.v_C = R_CI * rates.v_C;
    rates.covariance_v_C =
        R_CI * rates.covariance_v_C * R_CI.transpose() + by_scale(rates.v_C, scale_sigma);
    publish(rates, *m);
  }
}

}  // namespace

bool is_confirmed(std::span<const MotionState> published) {
  if (published.empty() || published.back().mode != Mode::kLost) {
    return true;
  }
  const auto last = std::find_if(
      published.rbegin(), published.rend(), [](const MotionState& m) { return m.pose_valid; });
  return last != published.rend() &&
         std::count_if(published.begin(), published.end(), [&](const MotionState& m) {
           return m.pose_valid && m.target_frame == last->target_frame;
         }) >= static_cast<std::ptrdiff_t>(kPosesTried);
}

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

PoseCovariance converged_drift(const GroundView& view) {
  MapDrift held = view.drift;
  fix_both_ends(&held);
  return scaled(covariance(held), view.scale.metres_per_mu);
}

RigidModel model_of(std::span<const PoseSample> samples,
                    double body_radius,
                    const GroundView& view) {
  if (view.parameters.motion.mode == MotionMode::kPaper || samples.empty()) {
    return {};
  }
  // Before a disturbance the body moved otherwise.
  samples = samples.last(samples_since(samples, view.moves_so_since_ns));
  if (samples.empty()) {
    return {};
  }
  auto snapshot = std::make_unique<MotionSnapshot>();
  auto workspace = std::make_unique<MotionWorkspace>();
  const std::size_t every = 1 + (samples.size() - 1) / PoseHistory::capacity();
  // The last one is always among them.
  for (std::size_t i = (samples.size() - 1) % every; i < samples.size(); i += every) {
    (void)snapshot->poses.push_back(samples[i]);
  }
  snapshot->drift = converged_drift(view);
  snapshot->body_radius = body_radius > 0.0 ? body_radius : 1.0;
  snapshot->options = view.parameters.motion;
  return fit_rigid_model(*snapshot, *workspace);
}

std::optional<RigidModel> model_of_map(std::span<const PoseSample> samples,
                                       const BodyFrame& body,
                                       const GroundView& view) {
  if (samples.empty()) {
    return std::nullopt;
  }
  const RigidModel model = transformed(view.model,
                                       {.scale = view.scale.metres_per_mu,
                                        .R_ba = body.R_TB.transpose(),
                                        .t_ba = -(body.R_TB.transpose() * body.centroid_T)});
  constexpr double kApart_rad = 0.02;  // axes that are not the model's are off by more
  for (const PoseSample* sample :
       {&samples.front(), &samples[samples.size() / 2], &samples.back()}) {
    const Result<MotionPrediction> at = predict_motion(model, sample->timestamp_ns);
    if (!at || !at.value().translation_known ||
        rotation_angle_rad(at.value().pose.R_CT, sample->pose.R_CT) > kApart_rad) {
      return std::nullopt;
    }
  }
  return model;
}

std::vector<MotionState> smoothed_motion(const RunPoses& run_poses,
                                         const RigidModel& model,
                                         const ServicerAttitude& servicer,
                                         const GroundView& view) {
  const auto& [poses, samples, published] = run_poses;
  std::vector<MotionState> smoothed;
  std::array<double, 4> q_last{1.0, 0.0, 0.0, 0.0};
  std::size_t next = 0;
  ModelOfRun run = of_run(model, published, view);
  const PoseCovariance drift = converged_drift(view);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    MotionState m = row_of(published[i], poses[i], view);
    AtFrame at = by_model(m.timestamp_ns, &run);
    const bool measured =
        next < samples.size() && poses[i].valid && samples[next].timestamp_ns == m.timestamp_ns;
    if (measured) {
      m.matches = static_cast<std::uint16_t>(poses[i].matches);
      m.inliers = static_cast<std::uint16_t>(poses[i].absolute.inliers);
      if (!at.pose) {
        at = by_measurement(side_of(samples, next, view.moves_so_since_ns),
                            drift,
                            view.parameters.motion,
                            at.rates);
      }
      ++next;
    }
    if (at.rates && times_are_contradicted(samples, next)) {
      at.rates.reset();
    }
    if (at.pose) {
      write_motion(at, servicer.R_IC(m.timestamp_ns).transpose(), view, &q_last, &m);
      m.mode = Mode::kTracking;  // with a pose from all frames there is nothing to acquire
    }
    smoothed.push_back(m);
  }
  return smoothed;
}

}  // namespace polhode::platform
