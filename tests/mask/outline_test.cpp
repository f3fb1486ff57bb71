// From evidence to an outline, and from the outline to the picture's edges.
#include "mask/outline.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "base/rng.hpp"
#include "moving_scene.hpp"

namespace polhode {
namespace {

using moving::overlap;

const cv::Size kSize(160, 120);
const cv::Rect kWhole(cv::Point(), kSize);
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

/// A panel's grid: lines 3 px wide, 12 px apart.
cv::Mat grid_evidence() {
  cv::Mat evidence(kSize, CV_32FC1, cv::Scalar(0.0F));
  for (int u = kBody.x; u < kBody.br().x; u += 12) {
    evidence(cv::Rect(u, kBody.y, 3, kBody.height)).setTo(4.0F);
  }
  return evidence;
}

TEST(FindOutline, ClosesGapsUpToTwiceTheRadius_AndNoWiderOnes) {
  OutlineScratch scratch;
  cv::Mat outline;
  ASSERT_TRUE(find_outline(grid_evidence(), {}, kWhole, 5, &scratch, &outline));
  EXPECT_EQ(outline.at<std::uint8_t>(60, 80), 255);
  EXPECT_EQ(outline.at<std::uint8_t>(60, 45), 0);
  ASSERT_TRUE(find_outline(grid_evidence(), {}, kWhole, 2, &scratch, &outline));
  EXPECT_EQ(outline.at<std::uint8_t>(60, 80), 0);
  EXPECT_EQ(outline.at<std::uint8_t>(60, 51), 255);
}

TEST(FindOutline, FindsNothing_WithoutEvidence) {
  OutlineScratch scratch;
  cv::Mat outline;
  EXPECT_FALSE(find_outline(
      cv::Mat(kSize, CV_32FC1, cv::Scalar(0.0F)), {}, kWhole, 5, &scratch, &outline));
  EXPECT_EQ(cv::countNonZero(outline), 0);
}

TEST(CutAtEdges, ComesBackToTheEdge_FromAnOutlineThatIsTooWideOnOneSide) {
  // As behind a moving target: 4 px that it has uncovered.
  cv::Mat outline = body();
  outline(cv::Rect(kBody.x - 4, kBody.y, 4, kBody.height)).setTo(255);
  ASSERT_LT(overlap(outline, body()), 0.95);
  cv::Mat opinion(kSize, CV_32FC1, cv::Scalar(-0.3F));
  opinion.setTo(0.3F, outline);
  cut_at_edges(picture(), opinion, {}, kReach_px, &outline);
  EXPECT_GE(overlap(outline, body()), 0.97);
}

TEST(CutAtEdges, LeavesAnEmptyOutlineAlone) {
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(0));
  cut_at_edges(picture(), cv::Mat(kSize, CV_32FC1, cv::Scalar(0.3F)), {}, kReach_px, &outline);
  EXPECT_EQ(cv::countNonZero(outline), 0);
}

TEST(CutAtEdges, LeavesAnOutlineThatFillsThePictureAlone) {
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(255));
  cut_at_edges(picture(), cv::Mat(kSize, CV_32FC1, cv::Scalar(-0.3F)), {}, kReach_px, &outline);
  EXPECT_EQ(cv::countNonZero(outline), kSize.area());
}

TEST(CutAtEdges, KeepsWhatIsCertain_WhateverTheOpinion) {
  cv::Mat outline = body();
  cv::Mat certain(kSize, CV_8UC1, cv::Scalar(0));
  cv::circle(certain, {80, 60}, 4, cv::Scalar(255), cv::FILLED);
  cut_at_edges(picture(), cv::Mat(kSize, CV_32FC1, cv::Scalar(-0.3F)), certain, kReach_px, &outline);
  EXPECT_EQ(cv::countNonZero(certain & ~outline), 0);
}

}  // namespace
}  // namespace polhode
