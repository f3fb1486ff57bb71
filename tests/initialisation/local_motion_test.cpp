#include "initialisation/local_motion.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace polhode::local_motion_test {
namespace {

/// A grid of tracks 10 px apart, in frame 0 and, under an affine motion, in frame 1.
class LocalMotionOf : public ::testing::Test {
 protected:
  void SetUp() override {
    affine_ << 0.9, -0.2, 0.15, 1.1;
    for (int y = 0; y < 6; ++y) {
      for (int x = 0; x < 6; ++x) {
        const Eigen::Vector2d from(10.0 * x, 10.0 * y);
        TrackPlaces places{.frames = 0b11U};
        places.px[0] = from.cast<float>();
        places.px[1] = moved(from).cast<float>();
        tracks_.push_back(places);
      }
    }
  }
  [[nodiscard]] Eigen::Vector2d moved(const Eigen::Vector2d& from) const {
    return affine_ * from + Eigen::Vector2d(7.0, -3.0);
  }
  [[nodiscard]] std::optional<LocalMotion> of(std::size_t track) const {
    return local_motion(tracks_, nearest_tracks(tracks_, track, 0), track, 0, 1);
  }
  Eigen::Matrix2d affine_;
  std::vector<TrackPlaces> tracks_;
  static constexpr std::size_t kInside = 14;
};

TEST_F(LocalMotionOf, TheNearestComeFirst_WithoutTheTrackItself) {
  const Neighbours nearest = nearest_tracks(tracks_, kInside, 0);
  float before = 0.0F;
  for (const std::size_t i : nearest) {
    EXPECT_NE(i, kInside);
    const float distance = (tracks_[i].px[0] - tracks_[kInside].px[0]).norm();
    EXPECT_GE(distance, before);
    before = distance;
  }
  EXPECT_EQ(nearest.size(), 35U);
}

TEST_F(LocalMotionOf, IsThatOfTheNeighbours) {
  tracks_[kInside].px[1] = {500.0F, 500.0F};  // its own is not asked
  const auto motion = of(kInside);
  ASSERT_TRUE(motion);
  EXPECT_LT((motion->affine - affine_).norm(), 0.02);
  EXPECT_LT((motion->place_px - moved(tracks_[kInside].px[0].cast<double>())).norm(), 0.05);
}

TEST_F(LocalMotionOf, LeavesOutNeighboursOfAnotherMotion) {
  for (const std::size_t wrong : {kInside - 1, kInside + 1, kInside + 6}) {
    tracks_[wrong].px[1] = tracks_[wrong].px[0] + Eigen::Vector2f(40.0F, 40.0F);
  }
  const auto motion = of(kInside);
  ASSERT_TRUE(motion);
  EXPECT_LT((motion->place_px - moved(tracks_[kInside].px[0].cast<double>())).norm(), 0.5);
}

TEST_F(LocalMotionOf, IsNotKnownByFewNeighbours) {
  for (std::size_t i = 5; i < tracks_.size(); ++i) {
    tracks_[i].frames = 0b01U;
  }
  EXPECT_FALSE(of(kInside));
}

TEST_F(LocalMotionOf, IsNotKnownWhereNeighboursFallTogether) {
  for (TrackPlaces& places : tracks_) {
    places.px[1] = {20.0F, 20.0F};
  }
  EXPECT_FALSE(of(kInside));
}

}  // namespace
}  // namespace polhode::local_motion_test
