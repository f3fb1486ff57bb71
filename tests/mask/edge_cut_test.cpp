// From an outline to image edges nearby.
#include "mask/edge_cut.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "base/rng.hpp"
#include "mask/grown.hpp"
#include "moving_scene.hpp"

namespace polhode::edge_cut_test {
namespace {

using moving::overlap;

const cv::Size kSize(160, 120);
const cv::Rect kBody(50, 40, 60, 40);
constexpr int kReach_px = 5;

cv::Mat body() {
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(0));
  outline(kBody).setTo(255);
  return outline;
}

/// A body 60 levels brighter than what is behind it.
cv::Mat image() {
  cv::Mat gray(kSize, CV_8UC1, cv::Scalar(80));
  gray(kBody).setTo(140);
  Rng rng(3, 0);
  for (std::size_t i = 0; i < gray.total(); ++i) {
    gray.data[i] = cv::saturate_cast<std::uint8_t>(gray.data[i] + 1.5 * rng.normal());
  }
  return gray;
}

/// Unary costs by pixels, or by cells of two.
void cut(const cv::Mat& gray,
         const cv::Mat& unary,
         const cv::Mat& seeds,
         int unary_px,
         const CutReach& reach,
         cv::Mat* outline) {
  ImageEdges edges;
  measure_edges(gray, cv::Rect(cv::Point(), gray.size()), &edges);
  cut_at_edges(edges, {.value = unary, .seeds = seeds, .cell_px = unary_px}, reach, outline);
}

/// As much for what the outline holds as against what is beside it, by cells of so many pixels.
cv::Mat unary_of(const cv::Mat& outline, int cell_px) {
  cv::Mat cells;
  cv::resize(outline,
             cells,
             coarser({cv::Point(), outline.size()}, cell_px).size(),
             0.0,
             0.0,
             cv::INTER_AREA);
  cv::Mat unary(cells.size(), CV_32FC1, cv::Scalar(-0.3F));
  unary.setTo(0.3F, cells > 127);
  return unary;
}

// verifies: MSK-04
TEST(CutAtEdges, ReturnsToTheEdge_FromAnOutlineThatIsTooWideOnOneSide) {
  // As behind a moving target: 4 px that it has uncovered.
  cv::Mat outline = body();
  outline(cv::Rect(kBody.x - 4, kBody.y, 4, kBody.height)).setTo(255);
  ASSERT_LT(overlap(outline, body()), 0.95);
  cut(image(), unary_of(outline, 1), {}, 1, {.px = kReach_px}, &outline);
  EXPECT_GE(overlap(outline, body()), 0.97);
}

TEST(CutAtEdges, LeavesAnEmptyOutlineAlone) {
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(0));
  cut(image(), cv::Mat(kSize, CV_32FC1, cv::Scalar(0.3F)), {}, 1, {.px = kReach_px}, &outline);
  EXPECT_EQ(cv::countNonZero(outline), 0);
}

TEST(CutAtEdges, LeavesAnOutlineThatFillsTheImageAlone) {
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(255));
  cut(image(), cv::Mat(kSize, CV_32FC1, cv::Scalar(-0.3F)), {}, 1, {.px = kReach_px}, &outline);
  EXPECT_EQ(cv::countNonZero(outline), kSize.area());
}

/// A mosaic of colours, or printing: each neighbour is a step as large as any, and costs nothing.
TEST(CutAtEdges, LeavesAnOutlineWithinAPatternOfSinglePixelsAlone) {
  cv::Mat gray(kSize, CV_8UC1, cv::Scalar(80));
  for (int v = kBody.y; v < kBody.br().y; ++v) {
    for (int u = kBody.x; u < kBody.br().x; ++u) {
      gray.at<std::uint8_t>(v, u) = (u + v) % 2 == 0 ? 220 : 10;
    }
  }
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(0));
  outline(cv::Rect(65, 52, 30, 16)).setTo(255);
  const cv::Mat before = outline.clone();
  cut(gray, unary_of(outline, 1), {}, 1, {.px = 1}, &outline);
  EXPECT_EQ(cv::norm(outline, before, cv::NORM_INF), 0.0);
}

TEST(CutAtEdges, KeepsSeeds_WhateverTheUnaryCost) {
  cv::Mat outline = body();
  cv::Mat seeds(kSize, CV_8UC1, cv::Scalar(0));
  cv::circle(seeds, {80, 60}, 4, cv::Scalar(255), cv::FILLED);
  cut(image(), cv::Mat(kSize, CV_32FC1, cv::Scalar(-0.3F)), seeds, 1, {.px = kReach_px}, &outline);
  EXPECT_EQ(cv::countNonZero(seeds & ~outline), 0);
}

TEST(CutAtEdges, ByCells_EndsWithinACellOfTheEdge_FromFurtherAway) {
  cv::Mat outline = body();
  outline(cv::Rect(kBody.x - 9, kBody.y, 9, kBody.height)).setTo(255);
  cut(image(), unary_of(outline, 2), {}, 2, {.px = 10, .cell_px = 2}, &outline);
  cv::Mat widest;
  cv::Mat narrowest;
  cv::dilate(body(), widest, cv::Mat::ones(5, 5, CV_8UC1));
  cv::erode(body(), narrowest, cv::Mat::ones(5, 5, CV_8UC1));
  // Corners are cut off: a cell along both sides of each.
  EXPECT_EQ(cv::countNonZero(outline & ~widest), 0);
  EXPECT_LE(cv::countNonZero(narrowest & ~outline), 4 * 4);
}

TEST(CutAtEdges, ByCells_LeavesTheRowAndColumnThatFillNoCell) {
  const cv::Size odd(kSize.width - 1, kSize.height - 1);
  const cv::Mat gray = image()(cv::Rect(cv::Point(), odd)).clone();
  cv::Mat outline(odd, CV_8UC1, cv::Scalar(0));
  const cv::Rect corner(101, 81, odd.width - 101, odd.height - 81);
  outline(corner).setTo(255);
  cut(gray,
      unary_of(cv::Mat(odd, CV_8UC1, cv::Scalar(255)), 2),
      {},
      2,
      {.px = 10, .cell_px = 2},
      &outline);
  EXPECT_EQ(outline.size(), odd);
  EXPECT_EQ(cv::countNonZero(outline.row(odd.height - 1)), corner.width);
  EXPECT_EQ(cv::countNonZero(outline.col(odd.width - 1)), corner.height);
}

TEST(CutAtEdges, ByCells_KeepsSeeds_WhateverTheUnaryCost) {
  cv::Mat outline = body();
  cv::Mat seeds(kSize / 2, CV_8UC1, cv::Scalar(0));
  cv::circle(seeds, {25, 20}, 2, cv::Scalar(255), cv::FILLED);
  const cv::Mat against(kSize / 2, CV_32FC1, cv::Scalar(-3.0F));
  cut(image(), against, seeds, 2, {.px = 10, .cell_px = 2}, &outline);
  cv::Mat left_out;
  cv::resize(~outline, left_out, seeds.size(), 0.0, 0.0, cv::INTER_AREA);
  EXPECT_EQ(cv::countNonZero(seeds & left_out), 0);
  EXPECT_LT(cv::countNonZero(outline), kBody.area());
}

TEST(CutAtEdges, EndsAtTheEdge_ByPixels_WhereUnaryCostsAreByCells) {
  cv::Mat outline = body();
  outline(cv::Rect(kBody.x - 4, kBody.y, 4, kBody.height)).setTo(255);
  cut(image(), unary_of(outline, 2), {}, 2, {.px = kReach_px}, &outline);
  EXPECT_GE(overlap(outline, body()), 0.97);
}

TEST(CutAtEdges, LeavesWhatIsOutsideOfTheEdgesAlone) {
  cv::Mat outline = body();
  const cv::Mat unary(kSize, CV_32FC1, cv::Scalar(-3.0F));
  ImageEdges edges;
  measure_edges(image(), {20, 30, 60, 61}, &edges);
  EXPECT_EQ(edges.box, cv::Rect(20, 30, 60, 62));  // cells are whole
  cut_at_edges(edges, {.value = unary, .seeds = {}, .cell_px = 1}, {.px = kReach_px}, &outline);
  EXPECT_LT(cv::countNonZero(outline), kBody.area());
  const cv::Rect beyond(edges.box.br().x, 0, kSize.width - edges.box.br().x, kSize.height);
  EXPECT_EQ(cv::norm(outline(beyond), body()(beyond), cv::NORM_INF), 0.0);
}

}  // namespace
}  // namespace polhode::edge_cut_test
