#include "shape/scale_reading.hpp"

#include "map/track.hpp"

namespace polhode {
namespace {

FixedVector<Eigen::Vector3d, limits::kFeatures> seen_in(const Keyframe& keyframe, const Map& map) {
  FixedVector<Eigen::Vector3d, limits::kFeatures> seen;
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    if (keyframe.landmark_of[i].valid()) {
      (void)seen.push_back(map.landmarks[keyframe.landmark_of[i].index()].p_T);
    }
  }
  return seen;
}

ScaleChange read_in(const ScaleView& view,
                    const Map& map,
                    const ScaleInput& input,
                    ScaleState* scale) {
  return read_scale_in(view, *input.options, *input.camera, map.next_keyframe_number, scale);
}

}  // namespace

ScaleChange read_scale_in_frame(const MapState& map, const ScaleInput& input, ScaleState* scale) {
  return read_in({.pose = map.localised.absolute.pose, .landmarks_T = seen_landmarks_T(map).view()},
                 map.map,
                 input,
                 scale);
}

ScaleChange read_scale_in_keyframe(const Map& map, const ScaleInput& input, ScaleState* scale) {
  for (const Keyframe& keyframe : map.keyframes) {
    if (keyframe.used && keyframe.timestamp_ns == input.options->frame_timestamp_ns) {
      return read_in(
          {.pose = keyframe.pose, .landmarks_T = seen_in(keyframe, map).view()}, map, input, scale);
    }
  }
  return {};
}

ScaleChange read_scale(std::int64_t timestamp_ns,
                       const MapState& map,
                       const ScaleInput& input,
                       ScaleState* scale) {
  if (!names_frame(*input.options) ||
      !frame_reading_is_due(*input.options, map.map.next_keyframe_number, *scale)) {
    return {};
  }
  return timestamp_ns == input.options->frame_timestamp_ns
             ? read_scale_in_frame(map, input, scale)
             : read_scale_in_keyframe(map.map, input, scale);
}

}  // namespace polhode
