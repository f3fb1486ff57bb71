#include "mask/prior.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace polhode::prior_test {
namespace {

constexpr double kRadius_px = 40.0;

/// A working image of 160 x 120 pixels, one for each of the image's, in which nothing has been
/// compared yet.
std::unique_ptr<MaskState> fresh_state() {
  auto state = std::make_unique<MaskState>();
  state->foreground.log_odds = cv::Mat::zeros(120, 160, CV_32FC1);
  return state;
}

/// A grid of landmarks 8 px apart around the middle.
std::vector<cv::Point2f> grid() {
  std::vector<cv::Point2f> points;
  for (int y = -2; y <= 2; ++y) {
    for (int x = -2; x <= 2; ++x) {
      points.emplace_back(80.0F + 8.0F * static_cast<float>(x),
                          60.0F + 8.0F * static_cast<float>(y));
    }
  }
  return points;
}

bool set_at(const cv::Mat& set, int x, int y) { return set.at<std::uint8_t>(y, x) != 0; }

TEST(CellsOfBody, HoldTheLandmarksAndWhatTheBodyReachesBeyond) {
  EXPECT_TRUE(cells_of_body({}).empty());
  const std::vector<cv::Point2f> one{{41.0F, 22.0F}};
  EXPECT_EQ(cells_of_body({.points_px = one}), cv::Rect(10, 5, 1, 1));
  const cv::Rect wide = cells_of_body({.points_px = one, .radius_px = kRadius_px});
  EXPECT_LT(wide.x, 10);
  EXPECT_GT(wide.br().x, 11);
  EXPECT_NEAR(0.5 * (wide.x + wide.br().x), 10.5, 0.5);
  const std::vector<cv::Point2f> two{{41.0F, 22.0F}, {-1.0F, 3.0F}};  // one is out of the image
  EXPECT_EQ(cells_of_body({.points_px = two}), cv::Rect(cv::Point(-1, 0), cv::Point(11, 6)));
}

TEST(WorkingPixel, IsTheOneThatHoldsThePixelsCentre) {
  const auto state = fresh_state();
  EXPECT_EQ(working_pixel({7.0F, 3.4F}, *state), cv::Point(7, 3));
  state->points.decimation = 4;
  for (int x = 0; x < 40; ++x) {
    EXPECT_EQ(working_pixel({static_cast<float>(x), 1.0F}, *state), cv::Point(x / 4, 0)) << x;
  }
}

TEST(PlaceLandmarks, LeavesOutThoseWhereTheBackgroundIs_UnlessAllAreAskedFor) {
  const auto state = fresh_state();
  state->foreground.log_odds(cv::Rect(80, 0, 80, 120)).setTo(cv::Scalar(2.0F * kAgreement));
  const std::vector<cv::Point2f> points{{40.0F, 60.0F}, {120.0F, 60.0F}, {500.0F, 60.0F}};
  const MaskPrior prior{.points_px = points, .radius_px = kRadius_px};
  place_landmarks(prior, false, state.get());
  EXPECT_TRUE(set_at(state->map.seeds, 40, 60));
  EXPECT_FALSE(set_at(state->map.seeds, 120, 60));
  EXPECT_TRUE(state->map.seeds_box.contains({40, 60}));
  EXPECT_LT(state->map.seeds_box.br().x, 80);
  place_landmarks(prior, true, state.get());
  EXPECT_TRUE(set_at(state->map.seeds, 120, 60));
  place_landmarks({}, true, state.get());
  EXPECT_TRUE(state->map.seeds.empty());
}

TEST(PlaceLandmarks, CountsInCellsWhereTheLogOddsHaveThem) {
  const auto state = fresh_state();
  state->foreground.log_odds = cv::Mat::zeros(60, 80, CV_32FC1);
  state->foreground.step = 2;
  const std::vector<cv::Point2f> points{{41.0F, 61.0F}};
  place_landmarks({.points_px = points, .radius_px = kRadius_px}, false, state.get());
  EXPECT_TRUE(set_at(state->map.seeds, 20, 30));
  EXPECT_EQ(state->map.seeds.size(), cv::Size(80, 60));
}

TEST(PlacePrior, ClosesWhatLiesBetweenLandmarks_AndReachesABitBeyond) {
  const auto state = fresh_state();
  const std::vector<cv::Point2f> points = grid();
  EXPECT_FALSE(has_map(*state));
  place_prior({.points_px = points, .radius_px = kRadius_px}, state.get());
  ASSERT_TRUE(has_map(*state));
  EXPECT_TRUE(set_at(state->map.seeds, 84, 64));  // in the middle of four landmarks
  EXPECT_FALSE(set_at(state->map.seeds, 120, 60));
  EXPECT_TRUE(set_at(state->map.reach, 105, 60));   // 9 px from the last landmark
  EXPECT_FALSE(set_at(state->map.reach, 130, 60));  // 34 px: most of a radius
  // A small body's least distance.
  EXPECT_GT(near_px(*state), 2.0);
  state->map.radius_px = 1.0;
  EXPECT_EQ(near_px(*state), 2.0);
}

TEST(PlacePrior, LeavesGapsOpenWhereTheBackgroundIs) {
  const auto state = fresh_state();
  state->foreground.log_odds(cv::Rect(82, 62, 5, 5)).setTo(cv::Scalar(2.0F * kAgreement));
  const std::vector<cv::Point2f> points = grid();
  place_prior({.points_px = points, .radius_px = kRadius_px}, state.get());
  EXPECT_FALSE(set_at(state->map.seeds, 84, 64));
  EXPECT_TRUE(set_at(state->map.seeds, 76, 64));
}

TEST(PlacePrior, LeavesTheOutlineToMotionWhereEnoughPointsMove) {
  const auto state = fresh_state();
  state->background.target_tracks = kTracksEnough;
  const std::vector<cv::Point2f> points = grid();
  place_prior({.points_px = points, .radius_px = kRadius_px}, state.get());
  EXPECT_EQ(cv::countNonZero(state->map.seeds), 0);
  EXPECT_TRUE(state->map.seeds_box.empty());
  EXPECT_TRUE(set_at(state->map.landmark_discs, 80, 60));
  EXPECT_TRUE(has_map(*state));
}

TEST(PlacePrior, IsNoneWhereTheImagesContradictAllOfIt_OrThereIsNoMap) {
  const auto state = fresh_state();
  const std::vector<cv::Point2f> points = grid();
  const MaskPrior prior{.points_px = points, .radius_px = kRadius_px};
  place_prior(prior, state.get());
  ASSERT_TRUE(has_map(*state));
  place_prior({}, state.get());
  EXPECT_FALSE(has_map(*state));
  state->foreground.log_odds.setTo(cv::Scalar(2.0F * kAgreement));
  place_prior(prior, state.get());
  EXPECT_FALSE(has_map(*state));
  EXPECT_TRUE(state->map.seeds.empty());
}

}  // namespace
}  // namespace polhode::prior_test
