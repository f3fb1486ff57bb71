#include "mask/appearance.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

namespace polhode::appearance_test {
namespace {

const cv::Size kSize(200, 160);
const cv::Rect kBody(60, 50, 80, 60);
const cv::Rect kCell(110, 80, 30, 30);  // of the body, and missing in the outline

cv::Mat outline_without(const cv::Rect& missing) {
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(0));
  outline(kBody).setTo(255);
  outline(missing).setTo(0);
  return outline;
}

cv::Mat unary_cost_of(const cv::Mat& image,
                      const cv::Mat& outline,
                      const cv::Mat& matches = cv::Mat::zeros(kSize, CV_8UC1)) {
  cv::Mat unary_cost(kSize, CV_32FC1, cv::Scalar(0.0));
  AppearanceScratch scratch;
  add_appearance(
      {image, outline, matches, cv::Rect(cv::Point(), image.size())}, &scratch, &unary_cost);
  return unary_cost;
}

double mean_in(const cv::Mat& unary_cost, const cv::Rect& box) {
  return cv::mean(unary_cost(box))[0];
}

TEST(AddAppearance, CountsForAnEvenCellThatLooksLikeTheOthers) {
  cv::Mat image(kSize, CV_8UC1, cv::Scalar(150));
  image(kBody).setTo(30);
  const cv::Mat unary_cost = unary_cost_of(image, outline_without(kCell));
  const cv::Rect inner(kCell.x + 2, kCell.y + 2, kCell.width - 4, kCell.height - 4);
  EXPECT_GT(mean_in(unary_cost, inner), 0.3);                      // against an outline's 0.3
  EXPECT_LT(mean_in(unary_cost, cv::Rect(60, 20, 80, 25)), -0.3);  // the sky above
}

TEST(AddAppearance, SeparatesRoughFromEven_WhereTheLevelsAreAlike) {
  cv::Mat image(kSize, CV_8UC1, cv::Scalar(120));
  for (int row = 0; row < kSize.height; ++row) {
    for (int column = 0; column < kSize.width; ++column) {
      image.at<std::uint8_t>(row, column) = (row / 2 + column / 2) % 2 == 0 ? 113 : 127;
    }
  }
  image(kBody).setTo(120);
  const cv::Mat unary_cost = unary_cost_of(image, outline_without(kCell));
  EXPECT_GT(mean_in(unary_cost, cv::Rect(kCell.x + 2, kCell.y + 2, 26, 26)), 0.3);
  EXPECT_LT(mean_in(unary_cost, cv::Rect(60, 20, 80, 25)), -0.2);
}

TEST(AddAppearance, CountsAgainstTheTargetsAppearance_WhereTheBackgroundIsKnownToHaveIt) {
  cv::Mat image(kSize, CV_8UC1, cv::Scalar(150));
  image(kBody).setTo(30);
  cv::circle(image,
             cv::Point(90, 70),
             12,
             cv::Scalar(200),
             cv::FILLED);                // dark is not all that the target is
  const cv::Rect panel(20, 50, 30, 30);  // on the wall beside it
  image(panel).setTo(30);
  cv::Mat matches = cv::Mat::zeros(kSize, CV_8UC1);
  const cv::Rect inner(panel.x + 2, panel.y + 2, panel.width - 4, panel.height - 4);
  EXPECT_GT(mean_in(unary_cost_of(image, outline_without(kCell), matches), inner), 0.3);
  matches(panel).setTo(255);
  const cv::Mat unary_cost = unary_cost_of(image, outline_without(kCell), matches);
  EXPECT_LT(mean_in(unary_cost, inner), 0.0);
  EXPECT_GT(
      mean_in(unary_cost, cv::Rect(kCell.x + 2, kCell.y + 2, kCell.width - 4, kCell.height - 4)),
      0.3);
}

TEST(AddAppearance, AddsNothing_WhereTheBackgroundLooksTheSame) {
  const cv::Mat image(kSize, CV_8UC1, cv::Scalar(90));
  EXPECT_LT(cv::norm(unary_cost_of(image, outline_without(kCell)), cv::NORM_INF), 0.01);
}

TEST(AddAppearance, AddsTheSameWithinARegion_AndNothingOutsideOfIt) {
  cv::Mat image(kSize, CV_8UC1, cv::Scalar(150));
  image(kBody).setTo(30);
  const cv::Mat everywhere = unary_cost_of(image, outline_without(kCell));
  const cv::Rect region(kCell.x - 5, kCell.y - 5, 60, 45);  // within the body and beyond its corner
  cv::Mat unary_cost(kSize, CV_32FC1, cv::Scalar(0.0));
  AppearanceScratch scratch;
  const cv::Mat nothing_known = cv::Mat::zeros(kSize, CV_8UC1);
  add_appearance({image, outline_without(kCell), nothing_known, region}, &scratch, &unary_cost);
  EXPECT_EQ(cv::norm(unary_cost(region), everywhere(region), cv::NORM_INF), 0.0);
  EXPECT_GT(mean_in(unary_cost, kCell), 0.2);
  unary_cost(region).setTo(0.0);
  EXPECT_EQ(cv::countNonZero(unary_cost), 0);
}

TEST(AddAppearance, AddsNothing_WithoutAnOutline) {
  const cv::Mat image(kSize, CV_8UC1, cv::Scalar(90));
  EXPECT_EQ(cv::norm(unary_cost_of(image, cv::Mat::zeros(kSize, CV_8UC1)), cv::NORM_INF), 0.0);
}

TEST(AddAppearance, AddsByCells_WhatItAddsByTheirFirstPixels) {
  cv::Mat image(kSize, CV_8UC1, cv::Scalar(150));
  image(kBody).setTo(30);
  const cv::Mat by_pixels = unary_cost_of(image, outline_without(kCell));
  cv::Mat by_cells(kSize / 2, CV_32FC1, cv::Scalar(0.0));
  AppearanceScratch scratch;
  const cv::Mat nothing_known = cv::Mat::zeros(kSize, CV_8UC1);
  add_appearance({image, outline_without(kCell), nothing_known, cv::Rect(cv::Point(), kSize), 2},
                 &scratch,
                 &by_cells);
  int counted = 0;
  for (int row = 0; row < by_cells.rows; ++row) {
    for (int column = 0; column < by_cells.cols; ++column) {
      EXPECT_EQ(by_cells.at<float>(row, column), by_pixels.at<float>(2 * row, 2 * column));
      counted += by_cells.at<float>(row, column) != 0.0F ? 1 : 0;
    }
  }
  EXPECT_GT(counted, kCell.area() / 4);
}

}  // namespace
}  // namespace polhode::appearance_test
