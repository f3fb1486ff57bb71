#include "map/keyframes.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/so3.hpp"
#include "map/map_state.hpp"

namespace polhode {
namespace {

int observations(const Keyframe& keyframe) {
  int count = 0;
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    count += keyframe.landmark_of[i].valid() ? 1 : 0;
  }
  return count;
}

/// Part of the keyframe's landmarks that three other keyframes see as well.
double redundancy(const Keyframe& keyframe, const Map& map) {
  // As many as confirm a landmark: without this keyframe they still confirm it.
  constexpr int kOthers = 3;
  int seen = 0;
  int seen_elsewhere = 0;
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    const LandmarkId id = keyframe.landmark_of[i];
    if (id.valid()) {
      ++seen;
      seen_elsewhere += map.landmarks[id.index()].observations > kOthers ? 1 : 0;
    }
  }
  return seen == 0 ? 1.0 : static_cast<double>(seen_elsewhere) / seen;
}

/// Largest cosine between the keyframe's viewing direction (in T) and any other's.
double nearest_view_cosine(std::size_t slot, const Map& map) {
  const Eigen::Vector3d own = (map.keyframes[slot].pose.camera_T() - map.centre_T).normalized();
  double best = -1.0;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    if (k != slot && map.keyframes[k].used) {
      best =
          std::max(best, own.dot((map.keyframes[k].pose.camera_T() - map.centre_T).normalized()));
    }
  }
  return best;
}

/// Rotation between keyframes. Small while there is room: repeated observations of one place
/// improve the depths of a young map. Twice that in the second half of the table, to leave room
/// for aspects not yet seen.
double spacing_rad(const Map& map, const MapOptions& options) {
  const bool much_room = 2 * map.keyframe_count < options.keyframes_max;
  return (much_room ? 1.0 : 2.0) * options.keyframe_rotation_min_rad;
}

}  // namespace

bool wants_keyframe(const Map& map, const Pose& pose, int inliers, const MapOptions& options) {
  const auto order = keyframes_by_age(map);
  if (order.empty()) {
    return true;
  }
  // While a map is young, its depth error falls as 1 / a^2 with the angle a that its views span: a
  // view that adds 0.15 a to that reduces the error by a quarter.
  constexpr double kWider = 0.15;
  double nearest_rad = 10.0;
  double farthest_rad = 0.0;
  for (const KeyframeId id : order) {
    const double rad = rotation_angle_rad(map.keyframes[id.index()].pose.R_CT, pose.R_CT);
    nearest_rad = std::min(nearest_rad, rad);
    farthest_rad = std::max(farthest_rad, rad);
  }
  return nearest_rad > std::min(spacing_rad(map, options), kWider * farthest_rad) ||
         inliers < options.keyframe_tracked_min * observations(map.keyframes[order[0].index()]);
}

KeyframeId most_redundant(const Map& map) {
  constexpr double kAlone = 0.94;       // cos 20 deg
  constexpr std::uint32_t kNewest = 2;  // they support tracking in the next frames
  KeyframeId chosen;
  double highest = -1.0;
  for (std::size_t k = 0; k < map.keyframes.size(); ++k) {
    const Keyframe& keyframe = map.keyframes[k];
    if (!keyframe.used || keyframe.number + kNewest >= map.next_keyframe_number) {
      continue;
    }
    const double closeness = nearest_view_cosine(k, map);
    if (closeness < kAlone) {
      continue;
    }
    // Among equally redundant keyframes the one with the nearest neighbour goes: the rest cover the
    // view sphere more evenly.
    const double merit = redundancy(keyframe, map) + 0.01 * closeness;
    if (merit > highest) {
      highest = merit;
      chosen = KeyframeId::from_index(k);
    }
  }
  return chosen;
}

int make_room(int count, const MapOptions& options, Map* map) {
  int gone = 0;
  while (map->keyframe_count + count > options.keyframes_max) {
    const KeyframeId leaving = most_redundant(*map);
    if (!leaving.valid()) {
      break;
    }
    remove_keyframe(leaving, map);
    ++gone;
  }
  return gone;
}

KeyframeId insert_keyframe(const MapInput& frame, const LocalisedFrame& localised, Map* map) {
  const MapOptions& options = *frame.options;
  if (!is_before_camera(localised.absolute.pose)) {
    return {};
  }
  (void)make_room(1, options, map);
  if (map->keyframe_count >= options.keyframes_max) {
    return {};
  }
  const KeyframeId id = add_keyframe(map);
  if (!id.valid()) {
    return id;
  }
  Keyframe& keyframe = map->keyframes[id.index()];
  keyframe.frame = frame.frame;
  keyframe.timestamp_ns = frame.timestamp_ns;
  keyframe.R_IC = frame.R_IC;
  keyframe.pose = localised.absolute.pose;
  keyframe.features = *frame.features;
  for (const LandmarkMatch& match : localised.matches) {
    if (match.inlier && match.feature >= 0 && map->landmarks[match.landmark.index()].used) {
      add_observation(id, static_cast<std::size_t>(match.feature), match.landmark, map);
    }
  }
  return id;
}

}  // namespace polhode
