#include "map/update.hpp"

#include <algorithm>

#include "map/grow.hpp"

namespace polhode {

MapUpdate take_adjusted(const AdjustmentSnapshot& snapshot, bool usable, bool closed, MapState* s) {
  const MapCorrection correction = usable ? apply(snapshot, &s->map) : MapCorrection{};
  const bool applied = correction.timestamp_ns != INT64_MAX;
  if (closed && applied) {
    fix_both_ends(&s->drift);
  }
  return {.correction = correction, .applied = applied};
}

bool reaches_over_reanchoring(const MapState& s) {
  return std::any_of(s.map.keyframes.begin(), s.map.keyframes.end(), [&](const Keyframe& keyframe) {
    return keyframe.used && keyframe.number < s.drift.reanchored_keyframe;
  });
}

void correct_reference(const MapCorrection& correction, MapState* s) {
  if (s->reference.valid && s->reference.frame > correction.frame) {
    s->reference.pose = correction.moved(s->reference.pose);
  }
}

bool follow_keyframe(const Keyframe& keyframe, std::uint32_t frame, MapState* s) {
  if (s->reference.frame == keyframe.frame) {
    s->reference.pose = keyframe.pose;
  }
  if (frame != keyframe.frame) {
    return false;
  }
  s->localised.absolute.pose = keyframe.pose;
  return true;
}

void refresh_map(const CameraModel& camera, MapState* s) {
  refresh_landmarks(&s->map, camera);
  keep_matches_of_map(s->map, &s->reference.points);
}

bool pose_from_keyframe(const Keyframe& keyframe, const MapInput& input, MapState* s) {
  s->localised.matches.clear();
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    const LandmarkId id = keyframe.landmark_of[i];
    if (id.valid()) {
      const Feature& f = keyframe.features[i];
      (void)s->localised.matches.push_back({.landmark = id,
                                            .feature = static_cast<std::int32_t>(i),
                                            .u_px = f.u_px,
                                            .v_px = f.v_px,
                                            .normalised = f.normalised,
                                            .sigma_px = static_cast<double>(f.sigma_px)});
    }
  }
  s->localised.predicted = static_cast<int>(s->localised.matches.size());
  return solve_matched(
             localise_input(input, s->map), &keyframe.pose, &s->scratch.localise, &s->localised)
      .ok();
}

}  // namespace polhode
