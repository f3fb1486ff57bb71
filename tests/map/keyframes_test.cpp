#include "map/keyframes.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "map/map_state.hpp"
#include "synthetic_map.hpp"

namespace polhode::keyframes_test {
namespace {

using namespace synthetic;

/// A frame whose features are those of an image, each match an inlier where `is_inlier` indicates
/// so.
struct Frame {
  Picture image;
  std::unique_ptr<LocalisedFrame> localised = std::make_unique<LocalisedFrame>();
};

Frame frame_of(const std::vector<Spot>& body,
               const SyntheticMap& mapped,
               const Pose& pose,
               int outlier_every) {
  Rng rng(5, 121);
  Frame frame{.image = take_image(body, pose, kNoise_px, 0, &rng)};
  frame.localised->absolute.pose = pose;
  for (std::size_t i = 0; i < frame.image.spot_of.size(); ++i) {
    const LandmarkId id = mapped.landmark_of[static_cast<std::size_t>(frame.image.spot_of[i])];
    if (id.valid()) {
      const bool inlier = outlier_every == 0 || i % static_cast<std::size_t>(outlier_every) != 0;
      (void)frame.localised->matches.push_back(
          {.landmark = id, .feature = static_cast<std::int32_t>(i), .inlier = inlier});
    }
  }
  return frame;
}

KeyframeId insert(const Frame& frame, const MapOptions& options, Map* map) {
  return insert_keyframe({.frame = 77,
                          .timestamp_ns = 123456789,
                          .features = frame.image.features.get(),
                          .options = &options},
                         *frame.localised,
                         map);
}

TEST(WantsKeyframe, IsTrue_WhenThereIsNone) {
  const auto map = std::make_unique<Map>();
  EXPECT_TRUE(wants_keyframe(*map, turned(0.0), 0, {}));
}

TEST(WantsKeyframe, IsTrue_WhenTheBodyHasTurnedFromAllKeyframes_OrFewAreTracked) {
  const auto s = make_map(ball(300, 31), turn_by(0.2, 5), kNoise_px, 31);
  const MapOptions options{.keyframe_rotation_min_rad = 0.1, .keyframe_tracked_min = 0.5};
  constexpr int kMany = 1000;
  EXPECT_FALSE(wants_keyframe(*s.map, turned(0.8), kMany, options));
  EXPECT_FALSE(wants_keyframe(*s.map, turned(0.05), kMany, options)) << "near the first, long ago";
  EXPECT_FALSE(wants_keyframe(*s.map, turned(0.89), kMany, options));
  EXPECT_TRUE(wants_keyframe(*s.map, turned(0.91), kMany, options));
  EXPECT_TRUE(wants_keyframe(*s.map, turned(0.8), 0, options));
}

TEST(WantsKeyframe, AsksForMoreOfAYoungMap_ThatHasHardlyTurned) {
  const auto s = make_map(ball(300, 31), turn_by(0.02, 3), kNoise_px, 31);  // 0.04 rad in all
  constexpr int kMany = 1000;
  // 0.006 more are 0.15 of the 0.046 since the first; the spacing of a map that has turned is 0.05.
  EXPECT_FALSE(wants_keyframe(*s.map, turned(0.044), kMany, {}));
  EXPECT_TRUE(wants_keyframe(*s.map, turned(0.050), kMany, {}));
}

TEST(WantsKeyframe, AsksForHalfAsMany_WhenHalfOfTheTableIsTaken) {
  const auto s = make_map(ball(300, 31), turn_by(0.2, 8), kNoise_px, 31);
  constexpr int kMany = 1000;
  const MapOptions empty{.keyframes_max = 17, .keyframe_rotation_min_rad = 0.1};
  const MapOptions half_full{.keyframes_max = 16, .keyframe_rotation_min_rad = 0.1};
  EXPECT_TRUE(wants_keyframe(*s.map, turned(1.55), kMany, empty));
  EXPECT_FALSE(wants_keyframe(*s.map, turned(1.55), kMany, half_full));
  EXPECT_TRUE(wants_keyframe(*s.map, turned(1.61), kMany, half_full));
}

TEST(InsertKeyframe, StoresTheFrame_AndTiesItsInliersOnly) {
  const auto body = ball(300, 32);
  const auto s = make_map(body, turn_by(0.2, 3), kNoise_px, 32);
  const Frame frame = frame_of(body, s, turned(0.5), 4);
  const KeyframeId id = insert(frame, {}, s.map.get());
  ASSERT_TRUE(id.valid());
  const Keyframe& keyframe = s.map->keyframes[id.index()];
  EXPECT_EQ(keyframe.frame, 77U);
  EXPECT_EQ(keyframe.timestamp_ns, 123456789);
  EXPECT_EQ(keyframe.pose.p_CT, turned(0.5).p_CT);
  EXPECT_EQ(keyframe.features.size(), frame.image.features->size());
  int associated = 0;
  for (const LandmarkMatch& m : frame.localised->matches) {
    const LandmarkId held = keyframe.landmark_of[static_cast<std::size_t>(m.feature)];
    EXPECT_EQ(held.valid(), m.inlier);
    associated += held.valid() ? 1 : 0;
  }
  EXPECT_GT(associated, 30);
  EXPECT_EQ(broken_promise(*s.map), "");
}

TEST(InsertKeyframe, TiesNothing_ToWhatOpticalFlowFound) {
  const auto body = ball(300, 33);
  const auto s = make_map(body, turn_by(0.2, 3), kNoise_px, 33);
  const Frame frame = frame_of(body, s, turned(0.5), 0);
  for (LandmarkMatch& m : frame.localised->matches) {
    m.feature = -1;
  }
  const KeyframeId id = insert(frame, {}, s.map.get());
  for (const LandmarkId& landmark : s.map->keyframes[id.index()].landmark_of) {
    EXPECT_FALSE(landmark.valid());
  }
}

TEST(InsertKeyframe, KeepsTheLimit_AndLosesAnOldOne) {
  const auto body = ball(300, 34);
  const auto s = make_map(body, turn_by(0.06, 12), kNoise_px, 34);
  const MapOptions options{.keyframes_max = 12};
  const KeyframeId newest[2] = {s.keyframes[11], s.keyframes[10]};
  const std::uint32_t numbers[2] = {s.map->keyframes[newest[0].index()].number,
                                    s.map->keyframes[newest[1].index()].number};
  const KeyframeId id = insert(frame_of(body, s, turned(0.8), 0), options, s.map.get());
  ASSERT_TRUE(id.valid());
  EXPECT_EQ(s.map->keyframe_count, 12);
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(s.map->keyframes[newest[i].index()].used);
    EXPECT_EQ(s.map->keyframes[newest[i].index()].number, numbers[i]) << "the newest two never go";
  }
  EXPECT_EQ(broken_promise(*s.map), "");
}

TEST(InsertKeyframe, TakesNone_WhoseBodyLiesBehindTheCamera) {
  const auto body = ball(300, 35);
  const auto s = make_map(body, turn_by(0.2, 3), kNoise_px, 35);
  const Frame frame = frame_of(body, s, turned(0.5), 0);
  for (const double z : {0.0, -0.1, std::numeric_limits<double>::quiet_NaN()}) {
    frame.localised->absolute.pose.p_CT.z() = z;
    EXPECT_FALSE(insert(frame, {.keyframes_max = 3}, s.map.get()).valid()) << z;
    EXPECT_EQ(s.map->keyframe_count, 3) << "and none makes room for it";
  }
}

TEST(MostRedundant, IsNone_WhenEachKeyframeIsAloneInItsAspect) {
  const auto body = ball(300, 35);
  const auto s = make_map(body, turn_by(0.6, 8), kNoise_px, 35);
  EXPECT_FALSE(most_redundant(*s.map).valid());
  const int count = s.map->keyframe_count;
  const int landmarks = s.map->landmark_count;
  EXPECT_FALSE(
      insert(frame_of(body, s, turned(0.3), 0), {.keyframes_max = count}, s.map.get()).valid());
  EXPECT_EQ(s.map->keyframe_count, count);
  EXPECT_EQ(s.map->landmark_count, landmarks);
}

// verifies: MAP-06
TEST(MostRedundant, NeverTakesTheOnlyViewOfAnAspect) {
  // Ten views of one side, all within 20 deg, and one of another: the lonely one is the oldest.
  std::vector<Pose> poses{turned(1.5)};
  for (int k = 0; k < 10; ++k) {
    poses.push_back(turned(0.03 * k));
  }
  const auto s = make_map(ball(300, 36), poses, kNoise_px, 36);
  for (int i = 0; i < 8; ++i) {
    const KeyframeId leaving = most_redundant(*s.map);
    ASSERT_TRUE(leaving.valid());
    EXPECT_NE(leaving, s.keyframes[0]);
    remove_keyframe(leaving, s.map.get());
    refresh_landmarks(s.map.get(), camera());
  }
  EXPECT_FALSE(most_redundant(*s.map).valid()) << "the lonely one and the newest two are left";
}

}  // namespace
}  // namespace polhode::keyframes_test
