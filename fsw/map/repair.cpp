#include "map/repair.hpp"

#include <algorithm>
#include <array>

#include "base/validity.hpp"
#include "map/validity.hpp"

namespace polhode {
namespace {

// Least sizes of a usable map: an initialisation has no less, and a pose needs 12 landmarks.
constexpr int kKeyframesMin = 2;
constexpr int kLandmarksMin = 12;

/// @return flags repaired.
template <typename Table>
std::uint32_t repair_flags(Table* table) {
  std::uint32_t done = 0;
  for (auto& slot : *table) {
    done += validity::repair(&slot.used) ? 1 : 0;
  }
  return done;
}

template <typename Table>
bool used_are_counted(const Table& table, std::int32_t count) {
  return std::count_if(table.begin(), table.end(), [](const auto& slot) { return slot.used; }) ==
         count;
}

std::uint32_t drop_keyframes(std::int64_t now_ns, Map* map) {
  std::uint32_t dropped = 0;
  for (Keyframe& keyframe : map->keyframes) {
    if (keyframe.used && !head_is_valid(keyframe, *map, now_ns)) {
      keyframe.used = false;
      --map->keyframe_count;
      ++dropped;
    }
  }
  return dropped;
}

std::uint32_t drop_landmarks(Map* map) {
  std::uint32_t dropped = 0;
  for (Landmark& landmark : map->landmarks) {
    if (!landmark.used) {
      continue;
    }
    if (!head_is_valid(landmark, *map)) {
      landmark.used = false;
      --map->landmark_count;
      ++dropped;
    } else if (!views_are_valid(landmark, *map)) {
      landmark.views.clear();
      landmark.observations_changed = true;
      ++dropped;
    }
  }
  return dropped;
}

/// Blanks damaged features in place, as indices refer to them.
std::uint32_t blank_features(const CameraModel& camera, Map* map) {
  const Feature blank{.normalised = undistort(camera, Eigen::Vector2d::Zero())};
  std::uint32_t blanked = 0;
  for (Keyframe& keyframe : map->keyframes) {
    for (std::size_t i = 0; keyframe.used && i < keyframe.features.size(); ++i) {
      if (!is_valid(keyframe.features[i], camera)) {
        keyframe.features[i] = blank;
        keyframe.landmark_of[i] = {};
        ++blanked;
      }
    }
  }
  return blanked;
}

std::uint32_t drop_associations(Map* map) {
  std::uint32_t dropped = 0;
  for (Keyframe& keyframe : map->keyframes) {
    for (std::size_t i = 0; keyframe.used && i < keyframe.features.size(); ++i) {
      if (!association_is_valid(keyframe.landmark_of[i], *map)) {
        keyframe.landmark_of[i] = {};
        ++dropped;
      }
    }
  }
  return dropped;
}

/// Removes landmarks that fewer than two keyframes still see.
std::uint32_t count_observations(Map* map) {
  std::array<std::int32_t, limits::kLandmarks> counts{};
  for (const Keyframe& keyframe : map->keyframes) {
    for (std::size_t i = 0; keyframe.used && i < keyframe.features.size(); ++i) {
      if (keyframe.landmark_of[i].valid()) {
        ++counts[keyframe.landmark_of[i].index()];
      }
    }
  }
  std::uint32_t done = 0;
  for (std::size_t i = 0; i < map->landmarks.size(); ++i) {
    Landmark& landmark = map->landmarks[i];
    if (!landmark.used || landmark.observations == counts[i]) {
      continue;
    }
    landmark.observations = counts[i];
    landmark.observations_changed = true;
    ++done;
    if (counts[i] < 2) {
      landmark.used = false;
      --map->landmark_count;
    }
  }
  return done;
}

}  // namespace

Repair repair(const CameraModel& camera, std::int64_t now_ns, Map* map) {
  if (is_valid(*map, camera, now_ns)) {
    return {};
  }
  Repair done{.entries = repair_flags(&map->keyframes) + repair_flags(&map->landmarks)};
  const bool counted = used_are_counted(map->keyframes, map->keyframe_count) &&
                       used_are_counted(map->landmarks, map->landmark_count);
  if (counted) {
    done.entries += drop_keyframes(now_ns, map) + drop_landmarks(map);
    done.entries += blank_features(camera, map) + drop_associations(map);
    done.entries += count_observations(map);
    done.entries += drop_associations(map);  // to landmarks that have just gone
    map->landmark_free_from = 0;
    if (map->keyframe_count >= kKeyframesMin && map->landmark_count >= kLandmarksMin) {
      refresh_landmarks(map, camera);
    }
    done.entries = std::max(done.entries, 1U);  // at least one: the extent
  }
  done.reset = !counted || map->keyframe_count < kKeyframesMin ||
               map->landmark_count < kLandmarksMin || !is_valid(*map, camera, now_ns);
  if (done.reset) {
    clear(map);
    map->next_landmark_number = std::max(map->next_landmark_number, 0);
    map->centre_T.setZero();
    map->radius_mu = 0.0;
  }
  return done;
}

}  // namespace polhode
