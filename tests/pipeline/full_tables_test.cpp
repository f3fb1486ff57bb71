// Tables made to overflow, by tight limits and by pictures made for it: each leaves an estimator
// that goes on, with less, and a count of it.
#include <gtest/gtest.h>

#include <functional>

#include "../map/synthetic_map.hpp"
#include "bench.hpp"
#include "geometry/so3.hpp"
#include "state_of.hpp"

namespace polhode::full_tables_test {
namespace {

using namespace bench;

constexpr double kStep_rad = 0.06;

Pose truth(int frame) {
  return {.R_CT = so3_exp(Eigen::Vector3d(0.1, 1.0, 0.05).normalized() * kStep_rad * frame),
          .p_CT = {0.0, 0.0, 6.0}};
}

const Ball& ball() {
  static const Ball made(17);
  return made;
}

/// Shows the ball from frame `first` on.
int poses_over(int first, int count, Bench& b) {
  int poses = 0;
  for (int i = first; i < first + count; ++i) {
    poses += b.show(ball().seen_from(truth(i))).motion.pose_valid ? 1 : 0;
  }
  return poses;
}

/// Attitude error since frame `from`, at a frame that has a pose.
double turn_error_rad(const Pose& before, int from, const Pose& after, int to) {
  const Eigen::Matrix3d measured = after.R_CT * before.R_CT.transpose();
  const Eigen::Matrix3d true_turn = truth(to).R_CT * truth(from).R_CT.transpose();
  return rotation_angle_rad(measured, true_turn);
}

// verifies: MAP-06
TEST(FullTables, OfKeyframes_TheMostRedundantGo_AndTheBodyIsFollowed) {
  Parameters p = parameters();
  p.map.keyframes_max = 8;
  Bench b(p);
  constexpr int kFrames = 40;  // 137 deg: eight keyframes every 6 deg are not enough
  EXPECT_GE(poses_over(0, kFrames, b), kFrames - 8);
  const Component::State& s = state_of(*b.component);
  EXPECT_LE(s.mapping.map.keyframe_count, 8);
  EXPECT_GT(s.counters.keyframes_culled + s.counters.tables_full, 0U);
  EXPECT_EQ(s.counters.lost, 0U);
  EXPECT_EQ(synthetic::broken_promise(s.mapping.map), "");
}

// verifies: MAP-06
TEST(FullTables, OfLandmarks_ATenthGoes_AndTheBodyIsFollowed) {
  Bench b;
  constexpr int kBefore = 12;
  ASSERT_GT(poses_over(0, kBefore, b), 4);
  Component::State& s = state_of(*b.component);
  const Pose before = s.mapping.localised.absolute.pose;
  while (add_landmark(&s.mapping.map).valid()) {  // as if they had been seen long ago
  }
  ASSERT_EQ(static_cast<std::size_t>(s.mapping.map.landmark_count), limits::kLandmarks);
  constexpr int kAfter = 6;
  EXPECT_EQ(poses_over(kBefore, kAfter, b), kAfter);
  EXPECT_GT(s.counters.tables_full, 0U);
  EXPECT_GT(s.counters.landmarks_culled, 100U);
  EXPECT_LT(static_cast<std::size_t>(s.mapping.map.landmark_count), limits::kLandmarks);
  EXPECT_EQ(synthetic::broken_promise(s.mapping.map), "");
  EXPECT_LT(
      turn_error_rad(before, kBefore - 1, s.mapping.localised.absolute.pose, kBefore + kAfter - 1),
      0.03);
}

// verifies: FEA-04
TEST(FullTables, OfFeatures_LeaveTheStrongestOfEachPlace_AndABodyThatIsFollowed) {
  Parameters p = parameters();
  p.features.count_max = 60;
  Bench b(p);
  EXPECT_GT(poses_over(0, 20, b), 10);
  EXPECT_LE(state_of(*b.component).features.features.size(), 60U);
  EXPECT_EQ(synthetic::broken_promise(state_of(*b.component).mapping.map), "");
}

TEST(FullTables, OfPoses_TheOldestGo_AndTheMotionIsStillKnown) {
  Bench b;
  ASSERT_GT(poses_over(0, 14, b), 8);
  Component::State& s = state_of(*b.component);
  // The same poses long before, as many as there is room for.
  const PoseHistory now = s.motion.recent;
  PoseHistory long_ago;
  const std::int64_t first_ns = now[0].timestamp_ns - Bench::kSecond_ns * 1000;
  for (std::size_t i = 0; i < limits::kMotionPoses; ++i) {
    PoseSample sample = now[0];
    sample.timestamp_ns = first_ns + static_cast<std::int64_t>(i);
    ASSERT_TRUE(long_ago.push_back(sample));
  }
  s.motion.recent = long_ago;
  EXPECT_EQ(poses_over(14, 3, b), 3);
  EXPECT_EQ(s.motion.recent.size(), limits::kMotionPoses);
  EXPECT_EQ(s.motion.recent.back().timestamp_ns, s.clock.timestamp_ns);
  EXPECT_EQ(s.motion.recent[0].timestamp_ns, first_ns + 3);
}

Picture dots(int frame) {
  Picture picture(kWidth * kHeight, 0);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const bool dot = (u + frame) % 6 < 3 && v % 6 < 3;
      picture[static_cast<std::size_t>(v * kWidth + u)] = dot ? 230 : 40;
    }
  }
  return picture;
}

/// Texture over the whole picture, that moves on.
Picture full_frame(int frame) {
  static const Picture base = noise(77);
  Picture picture(kWidth * kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const int cell_u = (u + 5 * frame) / 4 % kWidth;
      picture[static_cast<std::size_t>(v * kWidth + u)] = static_cast<std::uint8_t>(
          60 + base[static_cast<std::size_t>(v / 4 * kWidth + cell_u)] / 2);
    }
  }
  return picture;
}

struct Hostile {
  const char* name;
  std::function<Picture(int)> picture;
};

class HostileImages : public ::testing::TestWithParam<Hostile> {};

TEST_P(HostileImages, BeforeTheMap_OverflowNothing_AndTheBodyIsAcquiredAfterwards) {
  Parameters p = parameters();
  p.features.count_max = static_cast<int>(limits::kFeatures);
  Bench b(p);
  constexpr int kFrames = 6;
  for (int i = 0; i < kFrames; ++i) {
    (void)b.show(GetParam().picture(i));
    EXPECT_LE(state_of(*b.component).features.features.size(), limits::kFeatures);
  }
  EXPECT_GT(poses_over(0, 24, b), 8);
  const Component::State& s = state_of(*b.component);
  EXPECT_EQ(s.mode.now, Mode::kTracking);
  EXPECT_EQ(synthetic::broken_promise(s.mapping.map), "");
}

// verifies: MAP-10
TEST_P(HostileImages, InPlaceOfTheBody_GiveNoWrongPose_AndTheBodyIsFoundAgain) {
  Bench b;
  constexpr int kBefore = 12;
  ASSERT_GT(poses_over(0, kBefore, b), 4);
  const Pose before = state_of(*b.component).mapping.localised.absolute.pose;
  const std::int32_t keyframes = state_of(*b.component).mapping.map.keyframe_count;
  for (int i = 0; i < 4; ++i) {
    EXPECT_FALSE(is_measured(b.show(GetParam().picture(i)).motion)) << i;
  }
  EXPECT_EQ(state_of(*b.component).mapping.map.keyframe_count, keyframes);
  EXPECT_GT(b.component->counters().lost, 0U);
  EXPECT_GT(poses_over(kBefore - 2, 4, b), 0) << "what it knew is seen again";
  const Component::State& s = state_of(*b.component);
  EXPECT_EQ(s.mode.now, Mode::kTracking);
  EXPECT_EQ(synthetic::broken_promise(s.mapping.map), "");
  EXPECT_LT(turn_error_rad(before, kBefore - 1, s.mapping.localised.absolute.pose, kBefore + 1),
            0.03);
}

INSTANTIATE_TEST_SUITE_P(
    All,
    HostileImages,
    ::testing::Values(Hostile{"Noise",
                              [](int i) { return noise(500 + static_cast<std::uint64_t>(i)); }},
                      Hostile{"DotGrid", dots},
                      Hostile{"FullFrameTexture", full_frame}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace polhode::full_tables_test
