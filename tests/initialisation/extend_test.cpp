#include "initialisation/extend.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/so3.hpp"
#include "solve/initial_geometry.hpp"

namespace polhode::extend_test {
namespace {

using testing::InitialGeometry;
using testing::make_initial_geometry;

constexpr int kFrames = 8;
constexpr int kPoints = 40;

/// The truth of a rotating box, of which frames and points are then taken away.
struct Known {
  InitialGeometry g;
  InitialHypothesis h;

  explicit Known(double noise = 0.0, std::uint64_t seed = 1)
      : g(make_initial_geometry(
            {.points = kPoints, .frames = kFrames, .extent_over_range = 0.1, .noise = noise},
            seed)) {
    h.frames = kFrames;
    h.tracks = kPoints;
    std::copy(g.poses.begin(), g.poses.end(), h.poses.begin());
    std::copy(g.points_T.begin(), g.points_T.end(), h.points_T.begin());
    std::fill_n(h.posed.begin(), kFrames, std::uint8_t{1});
    std::fill_n(h.known.begin(), kPoints, std::uint8_t{1});
  }

  void leave_frames(int first, int last) {
    for (int f = 0; f < kFrames; ++f) {
      const bool left = f >= first && f <= last;
      h.posed[static_cast<std::size_t>(f)] = left ? 1 : 0;
      if (!left) h.poses[static_cast<std::size_t>(f)] = {};
    }
  }
  void leave_points(int count) {
    for (auto i = static_cast<std::size_t>(count); i < kPoints; ++i) {
      h.known[i] = 0;
      h.points_T[i].setZero();
    }
  }
  [[nodiscard]] double attitude_error(int frame) const {
    const auto f = static_cast<std::size_t>(frame);
    return rotation_angle_rad(h.poses[f].R_CT, g.poses[f].R_CT);
  }
  bool pose(int frame) { return pose_frame(g.observations, g.times_s, frame, &h); }
  bool grow(int rounds) { return extend(g.observations, g.times_s, rounds, &h); }
  [[nodiscard]] int posed() const {
    return static_cast<int>(std::count(h.posed.begin(), h.posed.begin() + kFrames, 1));
  }
};

TEST(PoseFrame, FindsAnExactPose_BetweenAndBeyondThoseThatAreKnown) {
  for (const int frame : {0, 3, 7}) {
    Known k;
    k.h.posed[static_cast<std::size_t>(frame)] = 0;
    k.h.poses[static_cast<std::size_t>(frame)] = {};
    ASSERT_TRUE(k.pose(frame)) << frame;
    EXPECT_EQ(k.h.posed[static_cast<std::size_t>(frame)], 1);
    EXPECT_LT(k.attitude_error(frame), 1e-4) << frame;
  }
}

TEST(PoseFrame, StartsFromOnePoseAlone) {
  Known k;
  k.leave_frames(3, 3);
  ASSERT_TRUE(k.pose(4));
  EXPECT_LT(k.attitude_error(4), 1e-4);
}

TEST(PoseFrame, HoldsOutAgainstWrongPoints) {
  Known k(1.0);
  k.h.posed[4] = 0;
  for (std::size_t i = 0; i < kPoints; i += 5) k.h.points_T[i] *= -1.0;
  ASSERT_TRUE(k.pose(4));
  // 1e-4 across a body that subtends 0.1: a milliradian a point.
  EXPECT_LT(k.attitude_error(4), 5e-3);
}

TEST(PoseFrame, NeedsSixPointsAndAPosedFrame) {
  Known k;
  k.h.posed[4] = 0;
  k.h.poses[4] = {};
  k.leave_points(5);
  EXPECT_FALSE(k.pose(4));
  EXPECT_EQ(k.h.posed[4], 0);
  k.h.known[5] = 1;
  k.h.points_T[5] = k.g.points_T[5];
  EXPECT_TRUE(k.pose(4));
  Known none;
  none.leave_frames(1, 0);
  EXPECT_FALSE(none.pose(4));
}

TEST(AddPoints, TriangulatesWhatTwoPosedFramesSee) {
  Known k;
  k.leave_points(10);
  k.leave_frames(2, 5);
  add_points(k.g.observations, &k.h);
  for (std::size_t i = 0; i < kPoints; ++i) {
    EXPECT_EQ(k.h.known[i], 1) << i;
    EXPECT_LT((k.h.points_T[i] - k.g.points_T[i]).norm(), 1e-4) << i;
  }
}

TEST(AddPoints, LeavesWhatIsKnownAndWhatOneFrameSees) {
  Known k;
  k.leave_points(10);
  k.h.points_T[3] *= 2.0;
  const Eigen::Vector3d before = k.h.points_T[3];
  k.leave_frames(2, 2);
  add_points(k.g.observations, &k.h);
  EXPECT_EQ(std::count(k.h.known.begin(), k.h.known.begin() + kPoints, 1), 10);
  k.h.poses[3] = k.g.poses[3];
  k.h.posed[3] = 1;
  add_points(k.g.observations, &k.h);
  EXPECT_EQ(k.h.points_T[3], before);
}

TEST(AddPoints, TakesNoPointBeyondAFewExtents) {
  // Lines of sight that run side by side meet far behind the body.
  Known k;
  k.leave_points(39);
  for (TrackObservation& s : k.g.observations) {
    const InverseDepthPose& pose = k.g.poses[static_cast<std::size_t>(s.frame)];
    if (s.track == 39) {
      Eigen::Vector2d seen;
      ASSERT_TRUE(
          reproject(pose, k.g.poses[0].R_CT.transpose() * Eigen::Vector3d(0.0, 0.0, 8.0), &seen));
      s.normalised = seen;
    }
  }
  add_points(k.g.observations, &k.h);
  EXPECT_EQ(k.h.known[39], 0);
}

TEST(Extend, GrowsOneFrameToEachSideInARound) {
  Known k(1.0);
  k.leave_frames(3, 4);
  k.leave_points(20);
  ASSERT_TRUE(k.grow(1));
  EXPECT_EQ(k.posed(), 4);
  EXPECT_EQ(k.h.posed[2], 1);
  EXPECT_EQ(k.h.posed[5], 1);
  ASSERT_TRUE(k.grow(5));
  EXPECT_EQ(k.posed(), kFrames);
  EXPECT_EQ(std::count(k.h.known.begin(), k.h.known.begin() + kPoints, 1), kPoints);
  for (int f = 0; f < kFrames; ++f) EXPECT_LT(k.attitude_error(f), 0.02) << f;
  EXPECT_FALSE(k.grow(5));  // nothing is left to add
}

TEST(Extend, StepsOverAFrameWithoutImages) {
  Known k;
  k.leave_frames(2, 3);
  std::erase_if(k.g.observations, [](const TrackObservation& s) { return s.frame == 5; });
  ASSERT_TRUE(k.grow(6));
  EXPECT_EQ(k.h.posed[5], 0);
  EXPECT_EQ(k.h.posed[7], 1);
  EXPECT_LT(k.attitude_error(7), 1e-3);
}

TEST(Extend, AddsPointsButNoFrameInNoRounds) {
  Known k;
  k.leave_frames(2, 4);
  k.leave_points(20);
  EXPECT_FALSE(k.grow(0));
  EXPECT_EQ(k.posed(), 3);
  EXPECT_EQ(std::count(k.h.known.begin(), k.h.known.begin() + kPoints, 1), kPoints);
}

}  // namespace
}  // namespace polhode::extend_test
