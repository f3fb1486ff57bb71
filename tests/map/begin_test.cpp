#include "map/begin.hpp"

#include <gtest/gtest.h>

#include "synthetic_map.hpp"

namespace polhode::begin_test {
namespace {

using namespace synthetic;

/// Four frames, of which the second has no pose; five tracks, of which the last has no point.
struct Bench {
  std::unique_ptr<TrackTable> tracks = std::make_unique<TrackTable>();
  std::unique_ptr<InitialOutcome> outcome = std::make_unique<InitialOutcome>();
  std::unique_ptr<Map> map = std::make_unique<Map>();

  Bench() {
    tracks->frames.resize(4);
    outcome->frames.resize(4);
    for (std::size_t f = 0; f < 4; ++f) {
      tracks->frames[f].frame = static_cast<std::uint32_t>(10 + f);
      tracks->frames[f].timestamp_ns = 1000 * static_cast<std::int64_t>(10 + f);
      tracks->frames[f].features.resize(6);
      outcome->frames[f] = {.valid = f != 1, .pose = turned(0.1 * static_cast<double>(f))};
    }
    tracks->tracks.resize(5);
    outcome->points.resize(5);
    for (std::size_t t = 0; t < 5; ++t) {
      for (std::size_t f = 0; f < 4; ++f) {
        (void)tracks->tracks[t].points.push_back(
            {.frame = static_cast<std::int32_t>(f),
             .feature = static_cast<std::int32_t>((t + f) % 6)});
      }
      outcome->points[t] = {.valid = t != 4, .p_T = {0.1 * static_cast<double>(t), -0.3, 0.2}};
    }
    outcome->decision = InitialDecision::kCommit;
  }
};

TEST(BeginMap, MakesAKeyframeOfEachFrameWithAPose) {
  Bench b;
  begin_map({b.outcome.get(), 0, b.tracks.get()}, {}, b.map.get());
  const auto order = keyframes_by_age(*b.map);
  ASSERT_EQ(order.size(), 3U);
  const std::uint32_t frames[] = {13, 12, 10};
  for (std::size_t i = 0; i < 3; ++i) {
    const Keyframe& keyframe = b.map->keyframes[order[i].index()];
    EXPECT_EQ(keyframe.frame, frames[i]);
    EXPECT_EQ(keyframe.timestamp_ns, 1000 * static_cast<std::int64_t>(frames[i]));
    EXPECT_EQ(keyframe.pose.R_CT, turned(0.1 * (frames[i] - 10)).R_CT);
    EXPECT_EQ(keyframe.features.size(), 6U);
  }
}

TEST(BeginMap, MakesALandmarkOfEachTrackWithAPoint_SeenWhereItsFeaturesAre) {
  Bench b;
  begin_map({b.outcome.get(), 0, b.tracks.get()}, {}, b.map.get());
  EXPECT_EQ(b.map->landmark_count, 4);
  EXPECT_EQ(broken_promise(*b.map), "");
  for (const Landmark& landmark : b.map->landmarks) {
    if (landmark.used) {
      EXPECT_EQ(landmark.observations, 3) << "the frame without a pose ties nothing";
    }
  }
  for (const KeyframeId id : keyframes_by_age(*b.map)) {
    const Keyframe& keyframe = b.map->keyframes[id.index()];
    const auto f = static_cast<std::size_t>(keyframe.frame - 10);
    for (std::size_t t = 0; t < 5; ++t) {
      const LandmarkId associated = keyframe.landmark_of[(t + f) % 6];
      ASSERT_EQ(associated.valid(), t != 4);
      if (associated.valid()) {
        EXPECT_EQ(b.map->landmarks[associated.index()].p_T, b.outcome->points[t].p_T);
      }
    }
  }
}

TEST(BeginMap, LeavesOutAFrame_WhoseBodyLiesBehindTheCamera) {
  Bench b;
  b.outcome->frames[2].pose.p_CT.z() = -0.1;
  begin_map({b.outcome.get(), 0, b.tracks.get()}, {}, b.map.get());
  EXPECT_EQ(b.map->keyframe_count, 2);
  EXPECT_EQ(broken_promise(*b.map), "");
}

TEST(BeginMap, TakesNoMoreKeyframesThanAllowed) {
  Bench b;
  begin_map({b.outcome.get(), 0, b.tracks.get()}, {.keyframes_max = 2}, b.map.get());
  EXPECT_EQ(b.map->keyframe_count, 2);
  EXPECT_EQ(broken_promise(*b.map), "");
}

TEST(BeginMap, OfTheNewestFrames_LeavesOutTheFramesBefore) {
  Bench b;
  b.outcome->frames.resize(3);  // of the frames 11, 12 and 13; the second has no pose
  begin_map({b.outcome.get(), 1, b.tracks.get()}, {}, b.map.get());
  const auto order = keyframes_by_age(*b.map);
  ASSERT_EQ(order.size(), 2U);
  const std::uint32_t frames[] = {13, 11};
  for (std::size_t i = 0; i < 2; ++i) {
    const Keyframe& keyframe = b.map->keyframes[order[i].index()];
    EXPECT_EQ(keyframe.frame, frames[i]);
    EXPECT_EQ(keyframe.timestamp_ns, 1000 * static_cast<std::int64_t>(frames[i]));
    EXPECT_EQ(keyframe.pose.R_CT, turned(0.1 * (frames[i] - 11)).R_CT);
    for (std::size_t t = 0; t < 4; ++t) {
      const LandmarkId associated = keyframe.landmark_of[(t + frames[i] - 10) % 6];
      ASSERT_TRUE(associated.valid());
      EXPECT_EQ(b.map->landmarks[associated.index()].p_T, b.outcome->points[t].p_T);
    }
  }
  EXPECT_EQ(b.map->landmark_count, 4);
  for (const Landmark& landmark : b.map->landmarks) {
    EXPECT_EQ(landmark.observations, landmark.used ? 2 : 0);
  }
  EXPECT_EQ(broken_promise(*b.map), "");
}

}  // namespace
}  // namespace polhode::begin_test
