// From log-odds to an outline: gaps are closed, and nothing is found where they are 0.
#include "mask/outline.hpp"

#include <gtest/gtest.h>

namespace polhode::outline_test {
namespace {

const cv::Size kSize(160, 120);
const cv::Rect kWhole(cv::Point(), kSize);
const cv::Rect kBody(50, 40, 60, 40);

cv::Mat square(int radius) { return cv::Mat::ones(2 * radius + 1, 2 * radius + 1, CV_8UC1); }

/// A panel's grid: lines 3 px wide, 12 px apart.
cv::Mat grid_log_odds() {
  cv::Mat log_odds(kSize, CV_32FC1, cv::Scalar(0.0F));
  for (int u = kBody.x; u < kBody.br().x; u += 12) {
    log_odds(cv::Rect(u, kBody.y, 3, kBody.height)).setTo(4.0F);
  }
  return log_odds;
}

TEST(FindOutline, ClosesGapsThatTheElementDoesNotFitInto_AndNoWiderOnes) {
  OutlineScratch scratch;
  cv::Mat outline;
  ASSERT_TRUE(find_outline({grid_log_odds(), {}, kWhole, square(5)}, &scratch, &outline));
  EXPECT_EQ(outline.at<std::uint8_t>(60, 80), 255);
  EXPECT_EQ(outline.at<std::uint8_t>(60, 45), 0);
  ASSERT_TRUE(find_outline({grid_log_odds(), {}, kWhole, square(2)}, &scratch, &outline));
  EXPECT_EQ(outline.at<std::uint8_t>(60, 80), 0);
  EXPECT_EQ(outline.at<std::uint8_t>(60, 51), 255);
}

TEST(FindOutline, FindsNothing_WithoutLogOdds) {
  OutlineScratch scratch;
  cv::Mat outline;
  EXPECT_FALSE(find_outline(
      {cv::Mat(kSize, CV_32FC1, cv::Scalar(0.0F)), {}, kWhole, square(5)}, &scratch, &outline));
  EXPECT_EQ(cv::countNonZero(outline), 0);
}

}  // namespace
}  // namespace polhode::outline_test
