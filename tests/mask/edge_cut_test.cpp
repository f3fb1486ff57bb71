// From an outline to the picture's edges nearby.
#include "mask/edge_cut.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "base/rng.hpp"
#include "moving_scene.hpp"

namespace polhode {
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
cv::Mat picture() {
  cv::Mat gray(kSize, CV_8UC1, cv::Scalar(80));
  gray(kBody).setTo(140);
  Rng rng(3, 0);
  for (std::size_t i = 0; i < gray.total(); ++i) {
    gray.data[i] = cv::saturate_cast<std::uint8_t>(gray.data[i] + 1.5 * rng.normal());
  }
  return gray;
}

TEST(CutAtEdges, ComesBackToTheEdge_FromAnOutlineThatIsTooWideOnOneSide) {
  // As behind a moving target: 4 px that it has uncovered.
  cv::Mat outline = body();
  outline(cv::Rect(kBody.x - 4, kBody.y, 4, kBody.height)).setTo(255);
  ASSERT_LT(overlap(outline, body()), 0.95);
  cv::Mat opinion(kSize, CV_32FC1, cv::Scalar(-0.3F));
  opinion.setTo(0.3F, outline);
  cut_at_edges(picture(), opinion, {}, {.px = kReach_px}, &outline);
  EXPECT_GE(overlap(outline, body()), 0.97);
}

TEST(CutAtEdges, LeavesAnEmptyOutlineAlone) {
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(0));
  cut_at_edges(picture(), cv::Mat(kSize, CV_32FC1, cv::Scalar(0.3F)), {}, {.px = kReach_px}, &outline);
  EXPECT_EQ(cv::countNonZero(outline), 0);
}

TEST(CutAtEdges, LeavesAnOutlineThatFillsThePictureAlone) {
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(255));
  cut_at_edges(picture(), cv::Mat(kSize, CV_32FC1, cv::Scalar(-0.3F)), {}, {.px = kReach_px}, &outline);
  EXPECT_EQ(cv::countNonZero(outline), kSize.area());
}

TEST(CutAtEdges, KeepsWhatIsCertain_WhateverTheOpinion) {
  cv::Mat outline = body();
  cv::Mat certain(kSize, CV_8UC1, cv::Scalar(0));
  cv::circle(certain, {80, 60}, 4, cv::Scalar(255), cv::FILLED);
  cut_at_edges(picture(), cv::Mat(kSize, CV_32FC1, cv::Scalar(-0.3F)), certain, {.px = kReach_px}, &outline);
  EXPECT_EQ(cv::countNonZero(certain & ~outline), 0);
}

TEST(CutAtEdges, ByCells_EndsWithinACellOfTheEdge_FromFurtherAway) {
  cv::Mat outline = body();
  outline(cv::Rect(kBody.x - 9, kBody.y, 9, kBody.height)).setTo(255);
  cv::Mat opinion(kSize, CV_32FC1, cv::Scalar(-0.3F));
  opinion.setTo(0.3F, outline);
  cut_at_edges(picture(), opinion, {}, {.px = 10, .cell_px = 2}, &outline);
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
  const cv::Mat gray = picture()(cv::Rect(cv::Point(), odd)).clone();
  cv::Mat outline(odd, CV_8UC1, cv::Scalar(0));
  const cv::Rect corner(101, 81, odd.width - 101, odd.height - 81);  // with its margin, 65 by 45 px
  outline(corner).setTo(255);
  cut_at_edges(gray, cv::Mat(odd, CV_32FC1, cv::Scalar(0.3F)), {}, {.px = 10, .cell_px = 2}, &outline);
  EXPECT_EQ(outline.size(), odd);
  EXPECT_EQ(cv::countNonZero(outline.row(odd.height - 1)), corner.width);
  EXPECT_EQ(cv::countNonZero(outline.col(odd.width - 1)), corner.height);
}

TEST(CutAtEdges, ByCells_KeepsWhatIsCertain_WhateverTheOpinion) {
  cv::Mat outline = body();
  cv::Mat certain(kSize, CV_8UC1, cv::Scalar(0));
  cv::circle(certain, {51, 41}, 3, cv::Scalar(255), cv::FILLED);
  const cv::Mat against(kSize, CV_32FC1, cv::Scalar(-3.0F));
  cut_at_edges(picture(), against, certain, {.px = 10, .cell_px = 2}, &outline);
  EXPECT_EQ(cv::countNonZero(certain & ~outline), 0);
  EXPECT_LT(cv::countNonZero(outline), kBody.area());
}

}  // namespace
}  // namespace polhode
