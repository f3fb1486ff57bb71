// Foreground log-odds, by pixels or by cells.
#include "mask/foreground.hpp"

#include <gtest/gtest.h>

namespace polhode::foreground_test {
namespace {

const cv::Size kSize(160, 120);
const cv::Rect kBody(50, 40, 60, 40);

cv::Mat body() {
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(0));
  outline(kBody).setTo(255);
  return outline;
}

/// For the target within the body, against it beside.
ForegroundState log_odds_of_body(int step) {
  ForegroundState state;
  resize_log_odds(kSize, 1, &state);
  state.log_odds.setTo(-2.0);
  state.log_odds(kBody).setTo(3.0);
  resize_log_odds(kSize, step, &state);
  return state;
}

float at(const ForegroundState& state, int row, int column) {
  return state.log_odds.at<float>(row / state.step, column / state.step);
}

TEST(ResizeLogOdds, IsEmpty_OfTheFirstImage_OrOneOfAnotherSize) {
  ForegroundState state;
  resize_log_odds(kSize, 2, &state);
  EXPECT_EQ(state.log_odds.size(), kSize / 2);
  EXPECT_EQ(cv::countNonZero(state.log_odds), 0);
  state.log_odds.setTo(1.0);
  resize_log_odds({90, 71}, 2, &state);
  EXPECT_EQ(state.log_odds.size(), cv::Size(45, 36));  // the last row is in a cell of its own
  EXPECT_EQ(cv::countNonZero(state.log_odds), 0);
  state.log_odds.setTo(1.0);
  resize_log_odds({45, 36}, 1, &state);  // as many, of another image
  EXPECT_EQ(state.step, 1);
  EXPECT_EQ(cv::countNonZero(state.log_odds), 0);
}

TEST(ResizeLogOdds, KeepsWhatIsKnown_CoarserAndFinerAgain) {
  ForegroundState state = log_odds_of_body(2);
  EXPECT_EQ(state.step, 2);
  for (const int step : {2, 1}) {
    resize_log_odds(kSize, step, &state);
    EXPECT_EQ(state.log_odds.size(), kSize / step);
    EXPECT_EQ(at(state, 60, 80), 3.0F);
    EXPECT_EQ(at(state, 40, 50), 3.0F);
    EXPECT_EQ(at(state, 39, 49), -2.0F);
  }
}

TEST(RememberOutline, TakesWhatItHoldsAlong_AndResetsWhatItLeavesOut) {
  for (const int step : {1, 2}) {
    ForegroundState state = log_odds_of_body(step);
    const auto set = [&](const cv::Rect& box, double value) {
      state.log_odds(cv::Rect(box.tl() / step, box.size() / step)).setTo(value);
    };
    set({0, 0, 20, 20}, 2.0);     // outside of the outline, for the target
    set({80, 60, 10, 10}, -1.0);  // inside, contradicted by motion alone
    remember_outline(body(), &state);
    EXPECT_EQ(at(state, 10, 10), 0.0F);
    EXPECT_EQ(at(state, 10, 150), -2.0F);
    EXPECT_EQ(at(state, 55, 65), 3.0F);
    EXPECT_FLOAT_EQ(at(state, 65, 85), 0.7F);
  }
}

}  // namespace
}  // namespace polhode::foreground_test
