#include "mask/reduce.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "base/rng.hpp"

namespace polhode {
namespace {

cv::Mat noise(int width, int height, std::uint64_t seed) {
  Rng rng(seed, 0);
  cv::Mat gray(height, width, CV_8UC1);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      gray.at<std::uint8_t>(row, column) = static_cast<std::uint8_t>(rng.below(256));
    }
  }
  return gray;
}

cv::Mat resized(const cv::Mat& gray, int factor) {
  cv::Mat small;
  cv::resize(gray, small, {gray.cols / factor, gray.rows / factor}, 0.0, 0.0, cv::INTER_AREA);
  return small;
}

TEST(ReduceBy, IsResize_WithEachFactor) {
  for (int factor = 1; factor <= 16; ++factor) {
    // 37 and 5 blocks: rows end within a vector.
    const cv::Mat gray = noise(37 * factor, 5 * factor, static_cast<std::uint64_t>(factor));
    cv::Mat small;
    reduce_by(gray, factor, &small);
    EXPECT_EQ(cv::norm(small, resized(gray, factor), cv::NORM_INF), 0.0) << factor;
  }
}

TEST(ReduceBy, KeepsTheExtremes) {
  for (const int level : {0, 1, 254, 255}) {
    const cv::Mat gray(64, 64, CV_8UC1, cv::Scalar(level));
    cv::Mat small;
    reduce_by(gray, 16, &small);
    EXPECT_EQ(cv::norm(small, cv::Mat(4, 4, CV_8UC1, cv::Scalar(level)), cv::NORM_INF), 0.0);
  }
}

TEST(ReduceBy, LeavesOutWhatDoesNotFillABlock) {
  const cv::Mat gray = noise(50, 23, 1);
  cv::Mat small;
  reduce_by(gray, 4, &small);
  EXPECT_EQ(small.size(), cv::Size(12, 5));
  EXPECT_EQ(cv::norm(small, resized(gray(cv::Rect(0, 0, 48, 20)), 4), cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace polhode
