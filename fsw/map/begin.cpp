#include "map/begin.hpp"

#include <array>

namespace polhode {

void begin_map(const InitialMap& initial, const MapOptions& options, Map* map) {
  const InitialOutcome& outcome = *initial.outcome;
  const Similarity& to_T = initial.to_T;
  std::array<KeyframeId, limits::kInitialFrames> keyframe_of{};
  for (std::size_t f = 0; f < outcome.frames.size(); ++f) {
    const Pose pose = transformed(outcome.frames[f].pose, to_T);
    if (!outcome.frames[f].valid || !is_before_camera(pose) ||
        map->keyframe_count >= options.keyframes_max) {
      continue;
    }
    const KeyframeId id = add_keyframe(map);
    if (!id.valid()) {
      break;
    }
    Keyframe& keyframe = map->keyframes[id.index()];
    const CollectedFrame& frame = initial.tracks->frames[initial.first_frame + f];
    keyframe.frame = frame.frame;
    keyframe.timestamp_ns = frame.timestamp_ns;
    keyframe.R_IC = frame.R_IC;
    keyframe.pose = pose;
    keyframe.features = frame.features;
    keyframe_of[initial.first_frame + f] = id;
  }
  for (std::size_t t = 0; t < outcome.points.size(); ++t) {
    if (!outcome.points[t].valid) {
      continue;
    }
    const LandmarkId id = add_landmark(map);
    if (!id.valid()) {
      break;
    }
    map->landmarks[id.index()].p_T = to_T.apply(outcome.points[t].p_T);
    map->landmarks[id.index()].created_keyframe = map->next_keyframe_number - 1;
    for (const TrackPoint& point : initial.tracks->tracks[t].points) {
      const KeyframeId keyframe = keyframe_of[static_cast<std::size_t>(point.frame)];
      if (keyframe.valid()) {
        add_observation(keyframe, static_cast<std::size_t>(point.feature), id, map);
      }
    }
  }
}

}  // namespace polhode
