#include "pipeline/mapping.hpp"

#include <algorithm>

#include "map/keyframes.hpp"
#include "map/window.hpp"

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

BundleOptions bundle_options(int iterations_max) { return {.iterations_max = iterations_max, .cauchy_sigma = 2.0}; }

/// Landmarks that were last seen long ago and are seen again now: a side has come back.
int returned_landmarks(const Component::State& s) {
  constexpr std::uint32_t kLongAgo_keyframes = 12;
  int returned = 0;
  for (const LandmarkMatch& match : s.localised.matches) {
    const Landmark& landmark = s.map.landmarks[match.landmark.index()];
    returned += match.inlier && landmark.used && landmark.seen_keyframe + kLongAgo_keyframes < s.map.next_keyframe_number;
  }
  return returned;
}

/// All keyframes are adjusted together when a side comes back, and each time the map has grown by a fifth.
bool wants_adjustment_of_all(const Component::State& s, int returned) {
  constexpr int kReturnedMin = 30;
  return returned >= kReturnedMin || 5 * s.map.keyframe_count > 6 * s.keyframes_at_last_adjustment;
}

}  // namespace

void adjust_all(int iterations_max, Component::State* s) {
  AdjustmentSnapshot snapshot = snapshot_all(s->map, s->camera);
  if (adjust(&snapshot, bundle_options(iterations_max)).usable) {
    apply(snapshot, &s->map);
  }
  s->keyframes_at_last_adjustment = s->map.keyframe_count;
}

void cull_map(Component::State* s) {
  s->noise_scale = std::max(1.0, residual_scale(s->map, s->camera));
  s->counters.landmarks_culled += static_cast<std::uint32_t>(cull_landmarks(s->camera, s->noise_scale, &s->map));
}

void settle_map(Component::State* s) {
  refresh_landmarks(&s->map, s->camera);
  adjust_all(s->parameters.map.adjustment_iterations_max, s);
  cull_map(s);
  refresh_landmarks(&s->map, s->camera);
  auto order = keyframes_by_age(s->map);
  std::reverse(order.begin(), order.end());
  for (const KeyframeId id : order) {
    create(id, s);
  }
  adjust_all(s->parameters.map.adjustment_iterations_max, s);
  cull_map(s);
  refresh_landmarks(&s->map, s->camera);
}

void extend_map(Component::State* s) {
  const LocalisedFrame& localised = s->localised;
  if (!wants_keyframe(s->map, localised.absolute.pose, localised.absolute.inliers, s->parameters.map)) {
    return;
  }
  const int returned = returned_landmarks(*s);
  const std::int32_t count_before = s->map.keyframe_count;
  const KeyframeId id =
      insert_keyframe(s->frame, s->timestamp_ns, s->features, localised, s->parameters.map, &s->map);
  if (!id.valid()) {
    ++s->counters.tables_full;
    return;
  }
  ++s->counters.keyframes_inserted;
  s->counters.keyframes_culled += s->map.keyframe_count == count_before ? 1 : 0;
  create(id, s);
  if (wants_adjustment_of_all(*s, returned)) {
    s->counters.closures += s->map.keyframe_count > s->parameters.map.window_keyframes ? 1 : 0;
    adjust_all(s->parameters.map.adjustment_iterations_max, s);
  } else {
    AdjustmentSnapshot snapshot = snapshot_window(s->map, s->camera, s->parameters.map.window_keyframes);
    if (adjust(&snapshot, bundle_options(s->parameters.map.adjustment_iterations_max)).usable) {
      apply(snapshot, &s->map);
    }
  }
  cull_map(s);
  refresh_landmarks(&s->map, s->camera);
  s->localised.absolute.pose = s->map.keyframes[id.index()].pose;
}

void remember_pose(std::int64_t timestamp_ns, const Pose& pose, const PoseCovariance& covariance,
                   Component::State* s) {
  // Times increase: the step has refused the others.
  (void)remember(s->poses, {.timestamp_ns = timestamp_ns, .pose = pose, .covariance = covariance});
}

}  // namespace polhode
