#include "mask/shrink.hpp"

#include <gtest/gtest.h>

#include <cstdint>

namespace polhode::shrink_test {
namespace {

/// Each pixel differs from its neighbours.
cv::Mat ramp(int width, int height) {
  cv::Mat out(height, width, CV_8UC1);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      out.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>((7 * x + 3 * y) % 200);
    }
  }
  return out;
}

double mean_of_square(const cv::Mat& image, int x, int y, int by) {
  return cv::mean(image(cv::Rect(by * x, by * y, by, by)))[0];
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

TEST(Shrink, IsTheMeanOverEachSquare) {
  for (const int by : {1, 2, 4, 8}) {
    const cv::Size size(12, 6);
    const cv::Mat image = ramp(by * size.width, by * size.height);
    cv::Mat out;
    shrink(image, size, by, &out);
    ASSERT_EQ(out.size(), size) << by;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        // Each halving rounds once: half a level, three times at most.
        EXPECT_NEAR(out.at<std::uint8_t>(y, x), mean_of_square(image, x, y, by), 1.5) << by;
      }
    }
  }
}

TEST(Shrink, ByOneIsTheImage) {
  const cv::Mat image = ramp(17, 9);
  cv::Mat out;
  shrink(image, image.size(), 1, &out);
  EXPECT_TRUE(same(out, image));
}

TEST(Shrink, TakesAnImageWhoseSizeIsNotAMultiple) {
  cv::Mat image(21, 30, CV_8UC1, cv::Scalar(77));
  cv::Mat out;
  shrink(image, {7, 5}, 4, &out);
  EXPECT_TRUE(same(out, cv::Mat(5, 7, CV_8UC1, cv::Scalar(77))));
}

TEST(CoverByHalf, SetsWhatIsCoveredByHalfOrMore) {
  cv::Mat set = cv::Mat::zeros(2, 6, CV_8UC1);
  set.at<std::uint8_t>(0, 0) = 255;                  // a quarter
  set(cv::Rect(2, 0, 2, 1)).setTo(cv::Scalar(255));  // half
  set(cv::Rect(4, 0, 2, 2)).setTo(cv::Scalar(255));  // all
  cv::Mat out;
  cover_by_half(set, {3, 1}, &out);
  EXPECT_EQ(out.at<std::uint8_t>(0, 0), 0);
  EXPECT_EQ(out.at<std::uint8_t>(0, 1), 255);
  EXPECT_EQ(out.at<std::uint8_t>(0, 2), 255);
}

TEST(CoverByHalf, MayReplaceItsInput) {
  cv::Mat set = cv::Mat::zeros(4, 4, CV_8UC1);
  set(cv::Rect(0, 0, 2, 2)).setTo(cv::Scalar(255));
  cover_by_half(set, {2, 2}, &set);
  ASSERT_EQ(set.size(), cv::Size(2, 2));
  EXPECT_EQ(set.at<std::uint8_t>(0, 0), 255);
  EXPECT_EQ(cv::countNonZero(set), 1);
}

TEST(FillFromCells, CopiesCellsOfOnePixelInTheBoxAlone) {
  const cv::Mat cells = ramp(8, 6);
  cv::Mat out(6, 8, CV_8UC1, cv::Scalar(250));
  const cv::Rect box(2, 1, 4, 3);
  fill_from_cells(cells, 1, box, &out);
  EXPECT_TRUE(same(out(box), cells(box)));
  out(box).setTo(cv::Scalar(250));
  EXPECT_TRUE(same(out, cv::Mat(6, 8, CV_8UC1, cv::Scalar(250))));
}

TEST(FillFromCells, EnlargesTheCellsThatTheBoxTouches) {
  const cv::Mat cells = ramp(5, 4);
  cv::Mat out(8, 10, CV_8UC1, cv::Scalar(250));
  // From an odd pixel to an odd pixel: cells 1 .. 3 across, 0 .. 1 down.
  fill_from_cells(cells, 2, {3, 1, 4, 2}, &out);
  for (int y = 0; y < out.rows; ++y) {
    for (int x = 0; x < out.cols; ++x) {
      const bool inside = x >= 2 && x < 8 && y < 4;
      EXPECT_EQ(out.at<std::uint8_t>(y, x), inside ? cells.at<std::uint8_t>(y / 2, x / 2) : 250)
          << x << ' ' << y;
    }
  }
}

TEST(FillFromCells, EndsWithAnOddImage) {
  const cv::Mat cells = ramp(4, 3);
  cv::Mat larger(6, 8, CV_8UC1, cv::Scalar(250));
  cv::Mat out = larger(cv::Rect(0, 0, 7, 5));  // half a cell is missing at either end
  fill_from_cells(cells, 2, {0, 0, 7, 5}, &out);
  for (int y = 0; y < out.rows; ++y) {
    for (int x = 0; x < out.cols; ++x) {
      EXPECT_EQ(out.at<std::uint8_t>(y, x), cells.at<std::uint8_t>(y / 2, x / 2)) << x << ' ' << y;
    }
  }
  EXPECT_EQ(cv::countNonZero(larger.row(5) != 250), 0);  // nothing is written beyond it
  EXPECT_EQ(cv::countNonZero(larger.col(7) != 250), 0);
}

TEST(FillFromCells, OfAnEmptyBoxWritesNothing) {
  const cv::Mat cells = ramp(4, 4);
  cv::Mat out(4, 4, CV_8UC1, cv::Scalar(250));
  fill_from_cells(cells, 1, {}, &out);
  EXPECT_TRUE(same(out, cv::Mat(4, 4, CV_8UC1, cv::Scalar(250))));
}

}  // namespace
}  // namespace polhode::shrink_test
