#include "initialisation/crop.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace polhode::crop_test {
namespace {

/// Levels rise by one a pixel along a row.
cv::Mat ramp(int width, int height) {
  cv::Mat gray(height, width, CV_8UC1);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width; ++u) {
      gray.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(u % 200);
    }
  }
  return gray;
}

std::vector<Feature> features_at(std::initializer_list<Eigen::Vector2f> places) {
  std::vector<Feature> features;
  for (const Eigen::Vector2f& place : places) {
    features.push_back({.u_px = place.x(), .v_px = place.y()});
  }
  return features;
}

double level_at(const Crop& crop, double u_px, double v_px) {
  const Eigen::Vector2d at = crop.to_crop({u_px, v_px});
  const auto x = static_cast<std::size_t>(std::lround(at.x()));
  const auto y = static_cast<std::size_t>(std::lround(at.y()));
  return crop.levels[y * static_cast<std::size_t>(crop.width) + x];
}

class Cropped : public ::testing::Test {
 protected:
  const Crop& crop_of(const cv::Mat& gray, const std::vector<Feature>& features) {
    keep_crop(gray, ++frame_, features, crops_.get());
    return crops_->kept[static_cast<std::size_t>(find_crop(frame_, *crops_))];
  }
  std::unique_ptr<Crops> crops_ = std::make_unique<Crops>();
  std::uint32_t frame_ = 0;
};

TEST_F(Cropped, HoldsTheImageAboutTheFeatures) {
  const Crop& crop = crop_of(ramp(180, 160), features_at({{50.3F, 60.0F}, {90.0F, 80.5F}}));
  EXPECT_EQ(crop.reduction, 1);
  EXPECT_LT(crop.width, 70);
  EXPECT_LT(crop.height, 50);
  EXPECT_EQ(level_at(crop, 50, 60), 50);
  EXPECT_EQ(level_at(crop, 97, 90), 97);
}

TEST_F(Cropped, EndsWhereTheImageEnds) {
  const Crop& crop = crop_of(ramp(60, 40), features_at({{1.0F, 1.0F}, {58.0F, 38.0F}}));
  EXPECT_EQ(crop.width, 60);
  EXPECT_EQ(crop.height, 40);
  EXPECT_EQ(crop.to_crop({0.0, 0.0}), Eigen::Vector2d(0.0, 0.0));
}

TEST_F(Cropped, OfALargeTargetIsReduced_AndPlacesGoThereAndBack) {
  const Crop& crop = crop_of(ramp(1400, 900), features_at({{20.0F, 30.0F}, {1300.0F, 800.0F}}));
  EXPECT_GT(crop.reduction, 1);
  EXPECT_LE(static_cast<std::size_t>(crop.width) * static_cast<std::size_t>(crop.height),
            limits::kCropPixels);
  for (const Eigen::Vector2d& place :
       {Eigen::Vector2d(100.0, 200.0), Eigen::Vector2d(733.2, 77.7)}) {
    EXPECT_LT((crop.to_image(crop.to_crop(place)) - place).norm(), 1e-9);
  }
  EXPECT_NEAR(level_at(crop, 150, 300), 150, crop.reduction);
}

TEST_F(Cropped, TheOldestGoesWhenThereIsNoMoreRoom) {
  const auto features = features_at({{20.0F, 20.0F}});
  const cv::Mat gray = ramp(60, 60);
  for (std::size_t i = 0; i <= limits::kInitialFrames; ++i) {
    (void)crop_of(gray, features);
  }
  EXPECT_EQ(find_crop(1, *crops_), -1);
  EXPECT_GE(find_crop(2, *crops_), 0);
}

TEST_F(Cropped, OfTwoFramesWithOneNumberTheNewerIsFound) {
  const auto features = features_at({{20.0F, 20.0F}});
  (void)crop_of(ramp(60, 60), features);
  frame_ = 0;
  EXPECT_EQ(crop_of(cv::Mat(60, 60, CV_8UC1, cv::Scalar(7.0)), features).levels[0], 7);
}

}  // namespace
}  // namespace polhode::crop_test
