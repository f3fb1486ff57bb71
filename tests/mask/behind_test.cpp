#include "mask/behind.hpp"

#include <gtest/gtest.h>

#include "base/rng.hpp"

namespace polhode::behind_test {
namespace {

constexpr int kColumns = 80;
constexpr int kRows = 60;

cv::Mat dark() { return {kRows, kColumns, CV_8UC1, cv::Scalar(0)}; }

/// Some rectangles, many of which reach the image border.
cv::Mat drawn(Rng* rng) {
  cv::Mat cells = dark();
  const int count = static_cast<int>(rng->below(4));
  for (int i = 0; i < count; ++i) {
    const cv::Point corner(static_cast<int>(rng->below(kColumns)),
                           static_cast<int>(rng->below(kRows)));
    const cv::Size size(1 + static_cast<int>(rng->below(40)), 1 + static_cast<int>(rng->below(30)));
    cells(cv::Rect(corner - cv::Point(size / 2), size) & cv::Rect({}, cells.size())).setTo(255);
  }
  return cells;
}

TEST(IsBehind, IsTrueOnlyWhereTheImageBorderIsLit) {
  Rng rng(1, 0);
  OutlineScratch scratch;
  int lit = 0;
  int behind = 0;
  for (int i = 0; i < 2000; ++i) {
    const cv::Mat cells = drawn(&rng);
    const bool was_behind = rng.below(2) == 1;
    const cv::Rect body = rng.below(2) == 1 ? cv::Rect(20, 10, 40, 50) : cv::Rect();
    const bool found_bits = is_behind(cells, body, was_behind, &scratch);
    EXPECT_TRUE(!found_bits || border_is_lit(cells)) << i;
    lit += border_is_lit(cells) ? 1 : 0;
    behind += found_bits ? 1 : 0;
  }
  EXPECT_GT(behind, 100);
  EXPECT_GT(lit, behind);
}

TEST(IsBehind, DoesNotCountABodyInTheMap) {
  cv::Mat cells = dark();
  cells(cv::Rect(20, 0, 30, kRows)).setTo(255);  // a fifth of the border, from top to bottom
  OutlineScratch scratch;
  EXPECT_TRUE(is_behind(cells, {}, true, &scratch));
  EXPECT_FALSE(is_behind(cells, cv::Rect(18, 0, 34, kRows), true, &scratch));
  EXPECT_TRUE(border_is_lit(cells)) << "or nobody would ask the map";
}

}  // namespace
}  // namespace polhode::behind_test
