#include "pipeline/scale_now.hpp"

#include "map/landmarks.hpp"

namespace polhode {
namespace {

using SeenLandmarks = FixedVector<Eigen::Vector3d, limits::kFeatures>;

SeenLandmarks seen_in_this_frame(const Component::State& s) {
  SeenLandmarks seen;
  for (const LandmarkMatch& match : s.localised.matches) {
    const Landmark& landmark = s.map.landmarks[match.landmark.index()];
    if (match.inlier && landmark.used) {
      (void)seen.push_back(landmark.p_T);
    }
  }
  return seen;
}

SeenLandmarks seen_in(const Keyframe& keyframe, const Map& map) {
  SeenLandmarks seen;
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    if (keyframe.landmark_of[i].valid()) {
      (void)seen.push_back(map.landmarks[keyframe.landmark_of[i].index()].p_T);
    }
  }
  return seen;
}

bool counted(const ScaleChange& change, Component::State* s) {
  s->counters.scale_contradictions += change.contradiction_began ? 1 : 0;
  return change.read;
}

bool read_in(const ScaleView& view, Component::State* s) {
  return counted(
      read_scale_in(view, s->parameters.scale, s->camera, s->map.next_keyframe_number, &s->scale),
      s);
}

}  // namespace

bool measure_scale_of(const Shape& shape, Component::State* s) {
  return counted(read_scale_of(shape, s->parameters.scale, &s->scale), s);
}

bool measure_scale_in_keyframe(Component::State* s) {
  const std::int64_t wanted_ns = s->parameters.scale.frame_timestamp_ns;
  for (const Keyframe& keyframe : s->map.keyframes) {
    if (keyframe.used && keyframe.timestamp_ns == wanted_ns) {
      return read_in({.pose = keyframe.pose, .landmarks_T = seen_in(keyframe, s->map).view()}, s);
    }
  }
  return false;
}

bool measure_scale_in_frame(Component::State* s) {
  return read_in({.pose = s->localised.absolute.pose, .landmarks_T = seen_in_this_frame(*s).view()},
                 s);
}

void measure_scale(Component::State* s) {
  const ScaleOptions& options = s->parameters.scale;
  if (!s->pose_valid || !names_frame(options) ||
      !frame_reading_is_due(options, s->map.next_keyframe_number, s->scale)) {
    return;
  }
  if (s->timestamp_ns == options.frame_timestamp_ns) {
    (void)measure_scale_in_frame(s);
  } else {
    (void)measure_scale_in_keyframe(s);
  }
}

}  // namespace polhode
