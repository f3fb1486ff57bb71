#include "map/map.hpp"

#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "base/median.hpp"

namespace polhode {
namespace {

Keyframe& at(Map* map, KeyframeId id) {
  POLHODE_ASSERT(id.valid() && map->keyframes[id.index()].used, id.slot);
  return map->keyframes[id.index()];
}

Landmark& at(Map* map, LandmarkId id) {
  POLHODE_ASSERT(id.valid() && map->landmarks[id.index()].used, id.slot);
  return map->landmarks[id.index()];
}

/// Slot for a view from this direction: the views that differ most are kept; a new one replaces the
/// one nearest to it once all slots are taken.
LandmarkView* place_for(const Eigen::Vector3d& direction_T, Landmark* landmark) {
  constexpr double kSameView = 0.966;  // cos 15 deg: nearer views look alike
  for (LandmarkView& kept : landmark->views) {
    if (kept.direction_T.dot(direction_T) > kSameView) {
      return &kept;  // the newer one has the newer light
    }
  }
  if (!landmark->views.full()) {
    landmark->views.resize(landmark->views.size() + 1);
    return &landmark->views.back();
  }
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < landmark->views.size(); ++i) {
    if (landmark->views[i].direction_T.dot(direction_T) >
        landmark->views[nearest].direction_T.dot(direction_T)) {
      nearest = i;
    }
  }
  return &landmark->views[nearest];
}

using LandmarkFlags = std::array<bool, limits::kLandmarks>;

/// Flags the landmarks whose views have changed, and empties their derived values.
void take_stale(Map* map, LandmarkFlags* stale) {
  for (std::size_t i = 0; i < map->landmarks.size(); ++i) {
    const Landmark& landmark = map->landmarks[i];
    (*stale)[i] =
        landmark.used && (landmark.observations_changed || landmark.p_T != landmark.refreshed_p_T);
  }
  for (Keyframe& keyframe : map->keyframes) {
    if (!keyframe.used || (keyframe.pose.R_CT == keyframe.refreshed_pose.R_CT &&
                           keyframe.pose.p_CT == keyframe.refreshed_pose.p_CT)) {
      continue;
    }
    keyframe.refreshed_pose = keyframe.pose;
    for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
      if (keyframe.landmark_of[i].valid()) {
        (*stale)[keyframe.landmark_of[i].index()] = true;
      }
    }
  }
  for (std::size_t i = 0; i < map->landmarks.size(); ++i) {
    if ((*stale)[i]) {
      Landmark& landmark = map->landmarks[i];
      landmark.observations_changed = false;
      landmark.refreshed_p_T = landmark.p_T;
      landmark.normal_T.setZero();
      landmark.size_mu = 0.0;
      landmark.spread_rad = 0.0;
      landmark.views.clear();
    }
  }
}

void refresh_extent(Map* map) {
  FixedVector<double, limits::kLandmarks> values;
  for (int axis = 0; axis < 3; ++axis) {
    values.clear();
    for (const Landmark& landmark : map->landmarks) {
      if (landmark.used) {
        (void)values.push_back(landmark.p_T[axis]);
      }
    }
    if (values.empty()) {
      return;
    }
    map->centre_T[axis] = median(values.view());
  }
  values.clear();
  for (const Landmark& landmark : map->landmarks) {
    if (landmark.used) {
      (void)values.push_back((landmark.p_T - map->centre_T).norm());
    }
  }
  map->radius_mu = ranked(values.view(), values.size() * 9 / 10);
}

}  // namespace

KeyframeId add_keyframe(Map* map) {
  for (std::size_t i = 0; i < map->keyframes.size(); ++i) {
    Keyframe& keyframe = map->keyframes[i];
    if (!keyframe.used) {
      keyframe.used = true;
      keyframe.number = map->next_keyframe_number++;
      keyframe.features.clear();
      keyframe.landmark_of.fill(LandmarkId{});
      ++map->keyframe_count;
      return KeyframeId::from_index(i);
    }
  }
  return {};
}

LandmarkId add_landmark(Map* map) {
  for (std::size_t i = map->landmark_free_from; i < map->landmarks.size(); ++i) {
    map->landmark_free_from = i + 1;
    if (!map->landmarks[i].used) {
      map->landmarks[i] = Landmark{};
      map->landmarks[i].used = true;
      map->landmarks[i].number = map->next_landmark_number++;
      ++map->landmark_count;
      return LandmarkId::from_index(i);
    }
  }
  return {};
}

void add_observation(KeyframeId keyframe, std::size_t feature, LandmarkId landmark, Map* map) {
  Keyframe& k = at(map, keyframe);
  POLHODE_ASSERT(feature < k.features.size() && !k.landmark_of[feature].valid(), feature);
  k.landmark_of[feature] = landmark;
  Landmark& l = at(map, landmark);
  ++l.observations;
  l.observations_changed = true;
  l.seen_keyframe = std::max(l.seen_keyframe, k.number);
}

void remove_observation(KeyframeId keyframe, std::size_t feature, Map* map) {
  Keyframe& k = at(map, keyframe);
  POLHODE_ASSERT(k.landmark_of[feature].valid(), feature);
  Landmark& l = at(map, k.landmark_of[feature]);
  --l.observations;
  l.observations_changed = true;
  k.landmark_of[feature] = LandmarkId{};
}

void remove_landmark(LandmarkId id, Map* map) { remove_landmarks({&id, 1}, map); }

void remove_landmarks(std::span<const LandmarkId> ids, Map* map) {
  int observations = 0;
  for (const LandmarkId id : ids) {
    Landmark& landmark = at(map, id);
    landmark.used = false;
    map->landmark_free_from = std::min(map->landmark_free_from, id.index());
    observations += landmark.observations;
  }
  map->landmark_count -= static_cast<std::int32_t>(ids.size());
  for (Keyframe& keyframe : map->keyframes) {
    for (std::size_t i = 0; keyframe.used && observations > 0 && i < keyframe.features.size();
         ++i) {
      LandmarkId& seen = keyframe.landmark_of[i];
      if (seen.valid() && !map->landmarks[seen.index()].used) {
        seen = LandmarkId{};
        --observations;
      }
    }
  }
}

void merge_landmarks(LandmarkId from, LandmarkId into, Map* map) {
  POLHODE_ASSERT(from != into, from.slot);
  for (std::size_t k = 0; k < map->keyframes.size(); ++k) {
    const Keyframe& keyframe = map->keyframes[k];
    std::ptrdiff_t moving = -1;
    bool seen_already = !keyframe.used;
    for (std::size_t i = 0; keyframe.used && i < keyframe.features.size(); ++i) {
      moving = keyframe.landmark_of[i] == from ? static_cast<std::ptrdiff_t>(i) : moving;
      seen_already = seen_already || keyframe.landmark_of[i] == into;
    }
    if (moving >= 0 && !seen_already) {
      const KeyframeId id = KeyframeId::from_index(k);
      remove_observation(id, static_cast<std::size_t>(moving), map);
      add_observation(id, static_cast<std::size_t>(moving), into, map);
    }
  }
  remove_landmark(from, map);
}

void remove_keyframe(KeyframeId id, Map* map) {
  Keyframe& keyframe = at(map, id);
  for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
    if (keyframe.landmark_of[i].valid()) {
      const LandmarkId landmark = keyframe.landmark_of[i];
      remove_observation(id, i, map);
      if (map->landmarks[landmark.index()].observations < 2) {
        remove_landmark(landmark, map);
      }
    }
  }
  keyframe.used = false;
  --map->keyframe_count;
}

void withdraw_keyframe(std::int64_t timestamp_ns, Map* map) {
  for (std::size_t k = 0; k < map->keyframes.size(); ++k) {
    if (map->keyframes[k].used && map->keyframes[k].timestamp_ns == timestamp_ns) {
      remove_keyframe(KeyframeId::from_index(k), map);
    }
  }
}

void refresh_landmarks(Map* map, const CameraModel& camera) {
  const double focal_px = camera.focal_px();
  std::array<double, limits::kLandmarks> spread_cosine;
  spread_cosine.fill(1.0);
  LandmarkFlags stale;
  take_stale(map, &stale);
  FixedVector<KeyframeId, limits::kKeyframes> order = keyframes_by_age(*map);
  std::reverse(order.begin(), order.end());
  for (const KeyframeId id : order) {
    const Keyframe& keyframe = map->keyframes[id.index()];
    const Eigen::Vector3d camera_T = keyframe.pose.camera_T();
    for (std::size_t i = 0; i < keyframe.features.size(); ++i) {
      if (!keyframe.landmark_of[i].valid() || !stale[keyframe.landmark_of[i].index()]) {
        continue;
      }
      Landmark& landmark = at(map, keyframe.landmark_of[i]);
      const Eigen::Vector3d direction_T = (camera_T - landmark.p_T).normalized();
      if (landmark.views.empty()) {
        landmark.oldest_direction_T = direction_T;
      }
      double& cosine = spread_cosine[keyframe.landmark_of[i].index()];
      cosine = std::min(cosine, landmark.oldest_direction_T.dot(direction_T));
      landmark.normal_T += direction_T;
      const double depth = keyframe.pose.to_camera(landmark.p_T).z();
      landmark.size_mu += static_cast<double>(keyframe.features[i].scale_px) * depth / focal_px;
      LandmarkView& view = *place_for(direction_T, &landmark);
      view.direction_T = direction_T;
      view.keyframe = id;
      view.feature = static_cast<std::int32_t>(i);
    }
  }
  for (std::size_t i = 0; i < map->landmarks.size(); ++i) {
    Landmark& landmark = map->landmarks[i];
    if (!stale[i] || landmark.observations == 0) {
      continue;
    }
    landmark.spread_rad = std::acos(std::max(-1.0, spread_cosine[i]));
    landmark.normal_T.normalize();
    landmark.size_mu /= landmark.observations;
    for (LandmarkView& view : landmark.views) {
      const Keyframe& keyframe = map->keyframes[view.keyframe.index()];
      view.descriptor = keyframe.features[static_cast<std::size_t>(view.feature)].descriptor;
    }
  }
  refresh_extent(map);
}

FixedVector<KeyframeId, limits::kKeyframes> keyframes_by_age(const Map& map) {
  FixedVector<KeyframeId, limits::kKeyframes> ids;
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    if (map.keyframes[i].used) {
      (void)ids.push_back(KeyframeId::from_index(i));
    }
  }
  std::sort(ids.begin(), ids.end(), [&](KeyframeId a, KeyframeId b) {
    return map.keyframes[a.index()].number > map.keyframes[b.index()].number;
  });
  return ids;
}

void clear(Map* map) {
  for (Keyframe& keyframe : map->keyframes) {
    keyframe.used = false;
  }
  for (Landmark& landmark : map->landmarks) {
    landmark.used = false;
  }
  map->keyframe_count = 0;
  map->landmark_count = 0;
  map->landmark_free_from = 0;
}

}  // namespace polhode
