#include "pipeline/mapping.hpp"

#include <algorithm>

#include "map/closure.hpp"
#include "map/keyframes.hpp"
#include "map/window.hpp"
#include "pipeline/track.hpp"

namespace polhode {
namespace {

void create(KeyframeId keyframe, Component::State* s) {
  const std::int32_t first = s->map.next_landmark_number;
  const CreateOptions options{.parallax_min_rad = s->parameters.map.landmark_parallax_min_rad,
                              .ratio_max = s->parameters.tracks.descriptor_ratio_max};
  s->counters.landmarks_created += static_cast<std::uint32_t>(
      create_landmarks(keyframe, options, s->camera, &s->create_scratch, &s->map));
  refresh_landmarks(&s->map, s->camera);
  extend_landmarks(first, s->camera, &s->map);
}

BundleOptions bundle_options(int iterations_max) {
  return {.iterations_max = iterations_max, .cauchy_sigma = 2.0};
}

/// All keyframes are adjusted together each time the map has grown by a fifth.
bool wants_adjustment_of_all(const Component::State& s) {
  return 5 * s.map.keyframe_count > 6 * s.keyframes_at_last_adjustment;
}

/// A loop that closes brings residuals of many sigma, which a narrow loss would take for outliers:
/// the loss starts as wide as a tenth of the body and narrows in two steps.
void adjust_closed_loop(Component::State* s) {
  for (const double cauchy_sigma : {100.0, 15.0}) {
    AdjustmentSnapshot snapshot = snapshot_all(s->map, s->camera);
    const BundleOptions options{.iterations_max = 20, .cauchy_sigma = cauchy_sigma};
    if (adjust(&snapshot, options, &s->bundle_workspace).usable) {
      apply(snapshot, &s->map);
    }
  }
  adjust_all(s->parameters.map.adjustment_iterations_max, s);
}

void adjust_window(Component::State* s) {
  AdjustmentSnapshot snapshot =
      snapshot_window(s->map, s->camera, s->parameters.map.window_keyframes);
  if (adjust(&snapshot,
             bundle_options(s->parameters.map.adjustment_iterations_max),
             &s->bundle_workspace)
          .usable) {
    apply(snapshot, &s->map);
  }
}

}  // namespace

void adjust_all(int iterations_max, Component::State* s) {
  AdjustmentSnapshot snapshot = snapshot_all(s->map, s->camera);
  if (adjust(&snapshot, bundle_options(iterations_max), &s->bundle_workspace).usable) {
    apply(snapshot, &s->map);
  }
  s->keyframes_at_last_adjustment = s->map.keyframe_count;
}

void cull_map(Component::State* s) {
  s->noise_scale = std::max(1.0, residual_scale(s->map, s->camera));
  s->counters.landmarks_culled +=
      static_cast<std::uint32_t>(cull_landmarks(s->camera, s->noise_scale, &s->map));
}

void settle_map(std::uint32_t first_keyframe, Component::State* s) {
  refresh_landmarks(&s->map, s->camera);
  adjust_all(s->parameters.map.adjustment_iterations_max, s);
  cull_map(s);
  refresh_landmarks(&s->map, s->camera);
  auto order = keyframes_by_age(s->map);
  std::reverse(order.begin(), order.end());
  for (const KeyframeId id : order) {
    if (s->map.keyframes[id.index()].number >= first_keyframe) {
      create(id, s);
    }
  }
  adjust_all(s->parameters.map.adjustment_iterations_max, s);
  cull_map(s);
  refresh_landmarks(&s->map, s->camera);
}

void extend_map(Component::State* s) {
  const LocalisedFrame& localised = s->localised;
  if (!wants_keyframe(
          s->map, localised.absolute.pose, localised.absolute.inliers, s->parameters.map)) {
    return;
  }
  const std::int32_t count_before = s->map.keyframe_count;
  const KeyframeId id = insert_keyframe(
      s->frame, s->timestamp_ns, s->features, localised, s->parameters.map, &s->map);
  if (!id.valid()) {
    ++s->counters.tables_full;
    return;
  }
  ++s->counters.keyframes_inserted;
  add_keyframe_error(localised, &s->drift);
  s->counters.keyframes_culled += s->map.keyframe_count == count_before ? 1 : 0;
  create(id, s);
  const int closed =
      close_loop(localise_input(*s), id, {}, &s->localise_scratch, &s->closure, &s->map);
  if (closed > 0) {
    ++s->counters.closures;
    hold_at_both_ends(&s->drift);
    adjust_closed_loop(s);
  } else if (wants_adjustment_of_all(*s)) {
    adjust_all(s->parameters.map.adjustment_iterations_max, s);
  } else {
    adjust_window(s);
  }
  cull_map(s);
  refresh_landmarks(&s->map, s->camera);
  s->localised.absolute.pose = s->map.keyframes[id.index()].pose;
}

void remember_pose(std::int64_t timestamp_ns,
                   const Pose& pose,
                   const PoseCovariance& covariance,
                   Component::State* s) {
  // Times increase: the step has refused the others.
  (void)remember(s->poses, {.timestamp_ns = timestamp_ns, .pose = pose, .covariance = covariance});
}

}  // namespace polhode
