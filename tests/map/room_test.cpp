#include "map/room.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "synthetic_map.hpp"

namespace polhode::room_test {
namespace {

using namespace synthetic;

/// Fills what is free with landmarks that nobody sees.
void fill(Map* map) {
  while (add_landmark(map).valid()) {
  }
}

TEST(MakeLandmarkRoom, LeavesAMapAlone_ThatHasRoom) {
  const auto s = make_map(ball(300, 51), turn_by(0.1, 6), kNoise_px, 51);
  const std::int32_t before = s.map->landmark_count;
  EXPECT_EQ(make_landmark_room(400, s.map.get()), 0);
  EXPECT_EQ(s.map->landmark_count, before);
}

TEST(MakeLandmarkRoom, FreesWhatIsWanted_AndNoMore) {
  const auto s = make_map(ball(300, 52), turn_by(0.1, 6), kNoise_px, 52);
  fill(s.map.get());
  ASSERT_EQ(s.map->landmark_count, static_cast<std::int32_t>(limits::kLandmarks));
  EXPECT_EQ(make_landmark_room(400, s.map.get()), 400);
  EXPECT_EQ(s.map->landmark_count, static_cast<std::int32_t>(limits::kLandmarks) - 400);
  EXPECT_EQ(broken_promise(*s.map), "");
  int made = 0;
  while (add_landmark(s.map.get()).valid()) {
    ++made;
  }
  EXPECT_EQ(made, 400);
}

TEST(MakeLandmarkRoom, GivesUpTheLeastConfirmedFirst) {
  const auto s = make_map(ball(300, 53), turn_by(0.1, 6), kNoise_px, 53);
  const std::int32_t confirmed = s.map->landmark_count;
  fill(s.map.get());
  (void)make_landmark_room(500, s.map.get());
  const auto seen =
      std::count_if(s.map->landmarks.begin(), s.map->landmarks.end(), [](const Landmark& landmark) {
        return landmark.used && landmark.observations > 0;
      });
  EXPECT_EQ(seen, confirmed) << "those that nobody sees were enough";
}

TEST(MakeLandmarkRoom, KeepsWhatTheNewestKeyframesSee) {
  const auto s = make_map(ball(300, 54), turn_by(0.1, 6), kNoise_px, 54);
  const Keyframe& newest = s.map->keyframes[s.keyframes.back().index()];
  const auto associated = [&] {
    return std::count_if(
        newest.landmark_of.begin(),
        newest.landmark_of.begin() + static_cast<std::ptrdiff_t>(newest.features.size()),
        [](LandmarkId id) { return id.valid(); });
  };
  const auto before = associated();
  ASSERT_GT(before, 20);
  (void)make_landmark_room(limits::kLandmarks, s.map.get());
  EXPECT_EQ(associated(), before);
  EXPECT_GT(s.map->landmark_count, 0);
  EXPECT_EQ(broken_promise(*s.map), "");
}

}  // namespace
}  // namespace polhode::room_test
