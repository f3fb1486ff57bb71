#include "map/grow.hpp"

#include <algorithm>

#include "map/closure.hpp"
#include "map/keyframes.hpp"
#include "map/room.hpp"
#include "mask/follow.hpp"

namespace polhode {
namespace {

/// Frees a tenth of a full table of landmarks at a time, so that this happens seldom.
void make_room_for_landmarks(std::size_t features_max, MapState* s) {
  const auto free = limits::kLandmarks - static_cast<std::size_t>(s->map.landmark_count);
  if (free >= features_max) {
    return;
  }
  ++s->counts.tables_full;
  const std::size_t wanted = std::max(limits::kLandmarks / 10, limits::kFeatures);
  s->counts.landmarks_culled += static_cast<std::uint32_t>(make_landmark_room(wanted, &s->map));
}

void create(KeyframeId keyframe, const MapInput& input, MapState* s) {
  make_room_for_landmarks(input.features_max, s);
  keep_matches_of_map(s->map, &s->localised.matches);
  const std::int32_t first = s->map.next_landmark_number;
  const CreateOptions options{.parallax_min_rad = input.options->landmark_parallax_min_rad,
                              .ratio_max = input.tracks->descriptor_ratio_max};
  s->counts.landmarks_created += static_cast<std::uint32_t>(
      create_landmarks(keyframe, options, *input.camera, &s->scratch.create, &s->map));
  refresh_landmarks(&s->map, *input.camera);
  extend_landmarks(first, *input.camera, &s->map);
}

}  // namespace

bool wants_keyframe(const MapInput& input, const MapState& s) {
  return wants_keyframe(
      s.map, s.localised.absolute.pose, s.localised.absolute.inliers, *input.options);
}

void veto_features(const MaskState& mask, Features* features, LandmarkMatches* matches) {
  if (!mask.sharp) {
    return;  // no feature is ruled out, and a copy of the features is large
  }
  std::array<std::int32_t, limits::kFeatures> now_at{};
  now_at.fill(-1);
  for (const LandmarkMatch& match : *matches) {
    if (match.inlier && match.feature >= 0) {
      now_at[static_cast<std::size_t>(match.feature)] = 0;
    }
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < features->size(); ++i) {
    const Feature& feature = (*features)[i];
    if (now_at[i] == 0 || !rules_out(mask, feature.u_px, feature.v_px)) {
      now_at[i] = static_cast<std::int32_t>(kept);
      (*features)[kept++] = feature;
    }
  }
  features->resize(kept);
  for (LandmarkMatch& match : *matches) {
    match.feature = match.feature >= 0 ? now_at[static_cast<std::size_t>(match.feature)] : -1;
  }
}

Growth grow_map(const MapInput& input, MapState* s) {
  const std::int32_t count_before = s->map.keyframe_count;
  const KeyframeId id = insert_keyframe(input, s->localised, &s->map);
  const std::int32_t count_without = s->map.keyframe_count - (id.valid() ? 1 : 0);
  s->counts.keyframes_culled += static_cast<std::uint32_t>(count_before - count_without);
  if (!id.valid()) {
    s->counts.tables_full += is_before_camera(s->localised.absolute.pose) ? 1 : 0;
    return {};
  }
  ++s->counts.keyframes_inserted;
  add_keyframe_error(s->localised, &s->drift);
  create(id, input, s);
  const int closed = close_loop(localise_input(input, s->map), id, {}, &s->scratch, &s->map);
  s->counts.closures += closed > 0 ? 1 : 0;
  return {.keyframe = id, .loop_found = closed > 0};
}

void complete_map(std::uint32_t first_keyframe, const MapInput& input, MapState* s) {
  auto order = keyframes_by_age(s->map);
  std::reverse(order.begin(), order.end());
  for (const KeyframeId id : order) {
    if (s->map.keyframes[id.index()].number >= first_keyframe) {
      create(id, input, s);
    }
  }
}

void cull_misfits(const CameraModel& camera, MapState* s) {
  const double noise_scale = std::max(1.0, residual_scale(s->map, camera));
  s->counts.landmarks_culled +=
      static_cast<std::uint32_t>(cull_landmarks(camera, noise_scale, &s->map));
}

void keep_matches_of_map(const Map& map, LandmarkMatches* matches) {
  const auto gone =
      std::remove_if(matches->begin(), matches->end(), [&](const LandmarkMatch& match) {
        return !map.landmarks[match.landmark.index()].used;
      });
  matches->resize(static_cast<std::size_t>(gone - matches->begin()));
}

}  // namespace polhode
