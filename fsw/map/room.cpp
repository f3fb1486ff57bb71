#include "map/room.hpp"

#include <algorithm>

namespace polhode {

int make_landmark_room(std::size_t wanted, Map* map) {
  const std::size_t free = limits::kLandmarks - static_cast<std::size_t>(map->landmark_count);
  if (free >= wanted) {
    return 0;
  }
  constexpr std::size_t kNewest = 2;  // keyframes: they carry the frames to come
  const auto order = keyframes_by_age(*map);
  const std::size_t young = std::min(kNewest, order.size());
  const std::uint32_t newest = young == 0 ? 0 : map->keyframes[order[young - 1].index()].number;
  FixedVector<LandmarkId, limits::kLandmarks> leaving;
  for (std::size_t i = 0; i < map->landmarks.size(); ++i) {
    if (map->landmarks[i].used && map->landmarks[i].seen_keyframe < newest) {
      (void)leaving.push_back(LandmarkId::from_index(i));
    }
  }
  std::sort(leaving.begin(), leaving.end(), [&](LandmarkId a, LandmarkId b) {
    const Landmark& one = map->landmarks[a.index()];
    const Landmark& two = map->landmarks[b.index()];
    if (one.observations != two.observations) {
      return one.observations < two.observations;
    }
    return one.seen_keyframe != two.seen_keyframe ? one.seen_keyframe < two.seen_keyframe
                                                  : one.number < two.number;
  });
  const std::size_t count = std::min(wanted - free, leaving.size());
  remove_landmarks(leaving.view().first(count), map);
  return static_cast<int>(count);
}

}  // namespace polhode
