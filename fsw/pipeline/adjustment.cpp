#include "pipeline/adjustment.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "map/map_state.hpp"
#include "map/rate_links.hpp"
#include "map/validity.hpp"
#include "motion/estimator.hpp"
#include "pipeline/job.hpp"
#include "pipeline/parameters.hpp"

namespace polhode {
namespace {

// Keyframes. Depth needs two observations of a landmark; three make it redundant.
constexpr int kWindowLeast = 3;

// A Cauchy loss halves an observation's weight at its own width. Of right observations 14 % lie
// beyond 2 sigma (Rayleigh); wrong ones lie far beyond.
constexpr double kCauchySigma = 2.0;

BundleOptions bundle_options(int iterations_max, double cauchy_sigma, const MapOptions& options) {
  return {.iterations_max = iterations_max,
          .cauchy_sigma = cauchy_sigma,
          .observations_max = static_cast<std::size_t>(options.adjustment_observations_max)};
}

/// All keyframes are adjusted together once a fifth of them are new, unless memory is short.
bool wants_adjustment_of_all(bool short_of_memory, const MapState& mapping) {
  const LastAdjustment& last = mapping.last_adjustment_of_all;
  return !short_of_memory &&
         5 * (mapping.map.next_keyframe_number - last.next_keyframe_number) > last.keyframes;
}

/// Steps until the result of an adjustment of the whole map is taken: the frames between the two
/// newest keyframes, within the configured limits. No window is adjusted meanwhile. With a keyframe
/// in each frame the map tolerates no longer delay.
std::uint32_t delay_of_all(const JobTimes& times, const Map& map) {
  const auto order = keyframes_by_age(map);
  if (order.size() < 2) {
    return times.delay;
  }
  const std::uint32_t apart =
      map.keyframes[order[0].index()].frame - map.keyframes[order[1].index()].frame;
  return std::clamp(apart, times.delay, times.delay_of_all);
}

/// @param closed  a closing loop has residuals of many sigma, outliers to a narrow loss. The loss
/// starts as wide as a tenth of the body and narrows in two steps.
void ask_for(AdjustmentReason reason,
             bool closed,
             const AdjustmentView& view,
             const Map& map,
             JobQueue* queue) {
  AdjustmentJob& job = queue->adjustment;
  JobTimes times = view.times;
  times.delay = job.of_all ? delay_of_all(times, map) : times.delay_of_window;
  job.reason = reason;
  job.closed = closed;
  job.rounds.clear();
  if (closed) {
    for (const double cauchy_sigma : {100.0, 15.0}) {
      (void)job.rounds.push_back(bundle_options(20, cauchy_sigma, view.parameters->map));
    }
  }
  const MapOptions& options = view.parameters->map;
  (void)job.rounds.push_back(
      bundle_options(options.adjustment_iterations_max, kCauchySigma, options));
  queue->counts.tables_full += job.snapshot.left_out > 0 ? 1 : 0;
  issue_job(&job, times, &queue->map, queue);
}

/// A motion that was fitted together with the map gives priors of the keyframes' poses. A visible
/// face with few features then does not bend the map.
void add_priors(const AdjustmentView& view, AdjustmentSnapshot* snapshot) {
  for (std::size_t k = 0; k < snapshot->poses.size(); ++k) {
    if (snapshot->pose_fixed[k] != 0) {
      continue;
    }
    const auto prior = pose_by_joint_model(
        *view.motion, view.parameters->motion, snapshot->timestamps_ns[k], snapshot->R_IC[k]);
    if (!prior || !is_before_camera(prior->pose)) {
      return;
    }
    Eigen::Matrix<double, 6, 6> by = Eigen::Matrix<double, 6, 6>::Identity();
    by.bottomRightCorner<3, 3>() = uvs_by_position(prior->pose.p_CT);
    const Eigen::Matrix<double, 6, 6> covariance = by * prior->covariance * by.transpose();
    const Eigen::LLT<Eigen::Matrix<double, 6, 6>> factor(covariance);
    if (factor.info() == Eigen::Success) {
      (void)snapshot->motion.priors.push_back(
          {.pose = static_cast<std::int32_t>(k),
           .mean = to_inverse_depth(prior->pose),
           .information = factor.solve(Eigen::Matrix<double, 6, 6>::Identity())});
    }
  }
}

}  // namespace

void prepare_adjustment_of_all(const AdjustmentView& view, MapState* mapping, AdjustmentJob* job) {
  const Map& map = mapping->map;
  snapshot_all(map, *view.camera, &job->snapshot);
  add_rate_links(&job->snapshot);
  mapping->last_adjustment_of_all = {.keyframes = static_cast<std::uint32_t>(map.keyframe_count),
                                     .next_keyframe_number = map.next_keyframe_number};
  job->motion = view.parameters->motion;
  // Keyframes added while the job is out are corrected by one rigid transform. That is too little
  // for a young map, which a joint fit with the motion reshapes.
  const auto order = keyframes_by_age(map);
  const bool alike =
      order.empty() ||
      moves_alike_since(map.keyframes[order.back().index()].timestamp_ns, *view.motion);
  const bool old_enough = map.keyframe_count >= 5 * static_cast<int>(view.times.delay_of_all);
  job->of_all = true;
  job->as_free_body = alike && old_enough && job->motion.mode == MotionMode::kDynamics &&
                      job->motion.forgetting_s == 0.0;
  job->body_radius_mu = map.radius_mu;
  job->model = view.motion->model;
  job->model_unwanted = false;
}

void ask_for_adjustment_of_all(AdjustmentReason reason,
                               const AdjustmentView& view,
                               MapState* mapping,
                               JobQueue* queue) {
  prepare_adjustment_of_all(view, mapping, &queue->adjustment);
  // The adjustment may run within the step (begins_within_step). A first free-body fit tries many
  // motions and takes ten times as long. The next adjustment includes it.
  queue->adjustment.as_free_body = false;
  ask_for(reason, false, view, mapping->map, queue);
}

void ask_for_adjustment_after_growth(const AdjustmentView& view,
                                     MapState* mapping,
                                     JobQueue* queue) {
  const Map& map = mapping->map;
  const auto order = keyframes_by_age(map);
  // The next step repairs a map that was damaged within this one; the adjustment waits for that.
  if (!mapping->growth.any || is_out(queue->map) || order.empty() ||
      !is_valid(map, *view.camera, view.now_ns)) {
    return;
  }
  const bool closed = std::exchange(mapping->growth, {}).closed;
  AdjustmentJob& job = queue->adjustment;
  job.keyframe = order[0];
  job.keyframe_number = map.keyframes[order[0].index()].number;
  if (closed || wants_adjustment_of_all(view.short_of_memory, *mapping)) {
    prepare_adjustment_of_all(view, mapping, &job);
  } else {
    const int window = view.parameters->map.window_keyframes / (view.short_of_memory ? 2 : 1);
    snapshot_window(map, *view.camera, std::max(kWindowLeast, window), &job.snapshot);
    add_priors(view, &job.snapshot);
    add_rate_links(&job.snapshot);
    job.of_all = false;
    job.as_free_body = false;
  }
  ask_for(AdjustmentReason::kMapGrown, closed, view, map, queue);
}

void set_rounds(int iterations_max, const MapOptions& options, AdjustmentJob* job) {
  job->closed = false;
  job->rounds.clear();
  (void)job->rounds.push_back(bundle_options(iterations_max, kCauchySigma, options));
}

}  // namespace polhode
