#include "pipeline/mapping.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "geometry/so3.hpp"
#include "map/closure.hpp"
#include "map/keyframes.hpp"
#include "map/room.hpp"
#include "map/window.hpp"
#include "pipeline/jobs.hpp"
#include "pipeline/localise_input.hpp"
#include "pipeline/motion_jobs.hpp"
#include "pipeline/restate.hpp"
#include "pipeline/work.hpp"

namespace polhode {
namespace {

/// A full table of landmarks gives up a tenth at a time, so that it does so seldom.
void make_room_for_landmarks(Component::State* s) {
  const auto free = limits::kLandmarks - static_cast<std::size_t>(s->map.landmark_count);
  if (free >= static_cast<std::size_t>(s->parameters.features.count_max)) {
    return;
  }
  ++s->counters.tables_full;
  const std::size_t wanted = std::max(limits::kLandmarks / 10, limits::kFeatures);
  s->counters.landmarks_culled += static_cast<std::uint32_t>(make_landmark_room(wanted, &s->map));
}

/// Landmarks go, and their places are taken by others.
void keep_matches_of_map(const Map& map, LandmarkMatches* matches) {
  const auto gone =
      std::remove_if(matches->begin(), matches->end(), [&](const LandmarkMatch& match) {
        return !map.landmarks[match.landmark.index()].used;
      });
  matches->resize(static_cast<std::size_t>(gone - matches->begin()));
}

void create(KeyframeId keyframe, Component::State* s) {
  make_room_for_landmarks(s);
  keep_matches_of_map(s->map, &s->localised.matches);
  const std::int32_t first = s->map.next_landmark_number;
  const CreateOptions options{.parallax_min_rad = s->parameters.map.landmark_parallax_min_rad,
                              .ratio_max = s->parameters.tracks.descriptor_ratio_max};
  s->counters.landmarks_created += static_cast<std::uint32_t>(
      create_landmarks(keyframe, options, s->camera, &s->create_scratch, &s->map));
  refresh_landmarks(&s->map, s->camera);
  extend_landmarks(first, s->camera, &s->map);
}

constexpr int kWindowLeast = 3;

BundleOptions bundle_options(int iterations_max) {
  return {.iterations_max = iterations_max, .cauchy_sigma = 2.0};
}

/// All keyframes are adjusted together each time the map has grown by a fifth, or had as many
/// replaced, unless memory is short.
bool wants_adjustment_of_all(const Component::State& s) {
  const LastAdjustment& last = s.last_adjustment_of_all;
  return s.steps_to_shed == 0 &&
         5 * (s.map.next_keyframe_number - last.next_keyframe_number) > last.keyframes;
}

/// @param closed  a loop that closes brings residuals of many sigma, which a narrow loss would take
/// for outliers: the loss starts as wide as a tenth of the body and narrows in two steps.
void ask_for(AdjustmentReason reason, bool closed, Component::State* s) {
  AdjustmentJob& job = s->job.adjustment;
  job.reason = reason;
  job.closed = closed;
  job.rounds.clear();
  if (closed) {
    for (const double cauchy_sigma : {100.0, 15.0}) {
      (void)job.rounds.push_back({.iterations_max = 20, .cauchy_sigma = cauchy_sigma});
    }
  }
  (void)job.rounds.push_back(bundle_options(s->parameters.map.adjustment_iterations_max));
  s->counters.tables_full += job.snapshot.left_out > 0 ? 1 : 0;
  issue_job(JobKind::kAdjustment, s);
}

/// Where the motion is known together with the map, it says where the keyframes are: a side that
/// shows little does not bend the map.
void add_priors(Component::State* s) {
  AdjustmentSnapshot& snapshot = s->job.adjustment.snapshot;
  for (std::size_t k = 0; k < snapshot.poses.size(); ++k) {
    if (snapshot.pose_fixed[k] != 0) {
      continue;
    }
    const auto prior = pose_by_map_model(
        s->motion, s->parameters.motion, snapshot.timestamps_ns[k], snapshot.R_IC[k]);
    if (!prior || !(prior->pose.p_CT.z() > 0.0)) {
      return;
    }
    Eigen::Matrix<double, 6, 6> by = Eigen::Matrix<double, 6, 6>::Identity();
    by.bottomRightCorner<3, 3>() = uvs_by_position(prior->pose.p_CT);
    const Eigen::Matrix<double, 6, 6> covariance = by * prior->covariance * by.transpose();
    const Eigen::LLT<Eigen::Matrix<double, 6, 6>> factor(covariance);
    if (factor.info() == Eigen::Success) {
      (void)snapshot.priors.push_back(
          {.pose = static_cast<std::int32_t>(k),
           .mean = to_inverse_depth(prior->pose),
           .information = factor.solve(Eigen::Matrix<double, 6, 6>::Identity())});
    }
  }
}

/// All of the map, with its motion where that is one of free bodies: paper mode knows no dynamics,
/// and what is to be forgotten must not shape the map.
void prepare_all(Component::State* s) {
  AdjustmentJob& job = s->job.adjustment;
  snapshot_all(s->map, s->camera, &job.snapshot);
  s->last_adjustment_of_all = {.keyframes = static_cast<std::uint32_t>(s->map.keyframe_count),
                               .next_keyframe_number = s->map.next_keyframe_number};
  job.motion = s->parameters.motion;
  // What comes while the job is out can only follow as a whole, and the motion reshapes a young
  // map.
  const bool old_enough = s->map.keyframe_count >= 5 * s->parameters.jobs.delay_frames;
  job.as_free_body =
      old_enough && job.motion.mode == MotionMode::kDynamics && job.motion.forgetting_s == 0.0;
  job.body_radius_mu = s->map.radius_mu;
  job.model = s->motion.model;
  job.model_unwanted = false;
}

void ask_for_all(AdjustmentReason reason, bool closed, Component::State* s) {
  prepare_all(s);
  ask_for(reason, closed, s);
}

void ask_after_growth(KeyframeId keyframe, bool closed, Component::State* s) {
  AdjustmentJob& job = s->job.adjustment;
  job.keyframe = keyframe;
  job.keyframe_number = s->map.keyframes[keyframe.index()].number;
  if (closed || wants_adjustment_of_all(*s)) {
    ask_for_all(AdjustmentReason::kMapGrown, closed, s);
    return;
  }
  const int window = s->parameters.map.window_keyframes / (s->steps_to_shed > 0 ? 2 : 1);
  snapshot_window(s->map, s->camera, std::max(kWindowLeast, window), &job.snapshot);
  add_priors(s);
  job.as_free_body = false;
  ask_for(AdjustmentReason::kMapGrown, closed, s);
}

/// A map that has just been adjusted for the first time gets all the landmarks that its keyframes
/// give.
void complete_map(Component::State* s) {
  auto order = keyframes_by_age(s->map);
  std::reverse(order.begin(), order.end());
  for (const KeyframeId id : order) {
    if (s->map.keyframes[id.index()].number >= s->job.adjustment.first_keyframe) {
      create(id, s);
    }
  }
  ask_for_all(AdjustmentReason::kMapCompleted, false, s);
}

/// Does the map still have what was there before the last start was bridged to it?
bool reaches_over_bridge(const Component::State& s) {
  return std::any_of(s.map.keyframes.begin(), s.map.keyframes.end(), [&](const Keyframe& keyframe) {
    return keyframe.used && keyframe.number < s.drift.bridged_keyframe;
  });
}

/// The map and, where one came out, the motion take the result over. A loop whose adjustment came
/// to nothing is still to be closed.
MapCorrection take_over(Component::State* s) {
  const AdjustmentJob& job = s->job.adjustment;
  const MapCorrection correction = job.usable ? apply(job.snapshot, &s->map) : MapCorrection{};
  const bool applied = correction.timestamp_ns != INT64_MAX;
  if (job.closed && applied) {
    hold_at_both_ends(&s->drift);
  } else if (job.closed) {
    s->growth.closed = true;
  }
  if (applied && job.as_free_body && job.model.accepted() && !job.model_unwanted) {
    take_map_motion(transformed(job.model, correction.back), s);
    if (reaches_over_bridge(*s)) {
      close_bridge(
          &s->drift);  // a motion is fitted to parts of a map only where sightings tie them
    }
  }
  return correction;
}

/// The keyframe that the map has grown by stands elsewhere now.
void move_with(const AdjustmentJob& job, Component::State* s) {
  const Keyframe& keyframe = s->map.keyframes[job.keyframe.index()];
  if (!keyframe.used || keyframe.number != job.keyframe_number) {
    return;
  }
  if (s->reference_frame == keyframe.frame) {
    s->reference.pose = keyframe.pose;
  }
  if (s->frame == keyframe.frame) {
    s->localised.absolute.pose = keyframe.pose;
    return;
  }
  move_pose(keyframe, &s->motion);
}

/// So does what was seen after the adjusted keyframes.
void move_since(const MapCorrection& correction, Component::State* s) {
  if (s->reference.valid && s->reference_frame > correction.frame) {
    s->reference.pose = correction.moved(s->reference.pose);
  }
  if (move_poses_with_map(s->map, correction.timestamp_ns, &s->motion)) {
    s->map_moved_rad = rotation_angle_rad(correction.before.R_CT, correction.after.R_CT);
  }
}

void ask_for_growth_waiting(Component::State* s) {
  const auto order = keyframes_by_age(s->map);
  if (s->growth.any && job_slot_free(*s) && !order.empty()) {
    const GrowthWaiting growth = std::exchange(s->growth, {});
    ask_after_growth(order[0], growth.closed, s);
  }
}

}  // namespace

void adjust_all(int iterations_max, Component::State* s) {
  AdjustmentJob& job = s->job.adjustment;
  prepare_all(s);
  job.closed = false;
  job.rounds.clear();
  (void)job.rounds.push_back(bundle_options(iterations_max));
  run_adjustment(&job);
  (void)take_over(s);
}

void cull_map(Component::State* s) {
  s->noise_scale = std::max(1.0, residual_scale(s->map, s->camera));
  s->counters.landmarks_culled +=
      static_cast<std::uint32_t>(cull_landmarks(s->camera, s->noise_scale, &s->map));
}

void settle_map(std::uint32_t first_keyframe, Component::State* s) {
  refresh_landmarks(&s->map, s->camera);
  s->job.adjustment.first_keyframe = first_keyframe;
  ask_for_all(AdjustmentReason::kMapBegun, false, s);
}

void take_adjustment(Component::State* s) {
  const AdjustmentJob& job = s->job.adjustment;
  move_since(take_over(s), s);
  if (!s->growth.closed) {
    cull_map(s);  // which would untie a loop that is still to be closed: its ends are sigmas apart
  }
  refresh_landmarks(&s->map, s->camera);
  keep_matches_of_map(s->map, &s->reference.points);
  switch (job.reason) {
    case AdjustmentReason::kMapBegun:
      complete_map(s);
      break;
    case AdjustmentReason::kMapCompleted:
      restate_poses(s);
      break;
    case AdjustmentReason::kMapGrown:
      move_with(job, s);
      break;
  }
  ask_for_growth_waiting(s);
}

bool may_extend_map(const Component::State& s) {
  const bool may_grow = job_slot_free(s) || s.job.kind == JobKind::kAdjustment;
  return may_grow &&
         wants_keyframe(
             s.map, s.localised.absolute.pose, s.localised.absolute.inliers, s.parameters.map);
}

void extend_map(Component::State* s) {
  if (!may_extend_map(*s)) {
    return;
  }
  const std::int32_t count_before = s->map.keyframe_count;
  const KeyframeId id = insert_keyframe(
      s->frame, s->timestamp_ns, s->features, s->localised, s->parameters.map, &s->map);
  const std::int32_t count_without = s->map.keyframe_count - (id.valid() ? 1 : 0);
  s->counters.keyframes_culled += static_cast<std::uint32_t>(count_before - count_without);
  if (!id.valid()) {
    ++s->counters.tables_full;
    return;
  }
  s->map.keyframes[id.index()].R_IC = s->motion.R_IC;
  ++s->counters.keyframes_inserted;
  add_keyframe_error(s->localised, &s->drift);
  create(id, s);
  const int closed =
      close_loop(localise_input(*s), id, {}, &s->localise_scratch, &s->closure, &s->map);
  if (closed > 0) {
    ++s->counters.closures;
  }
  s->growth = {.any = true, .closed = s->growth.closed || closed > 0};
  ask_for_growth_waiting(s);
}

}  // namespace polhode
