// Gray levels of the background, learned beside a target and compared where it stands.
#include "mask/background_model.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "base/rng.hpp"
#include "mask/outline.hpp"

namespace polhode::background_model_test {
namespace {

constexpr double kNoise = 2.0;
const cv::Size kSize(120, 90);
const cv::Rect kWhole(cv::Point(), kSize);
const cv::Rect kTarget(50, 40, 20, 20);

cv::Mat outline(const cv::Rect& target = kTarget) {
  cv::Mat mask(kSize, CV_8UC1, cv::Scalar(0));
  mask(target).setTo(255);
  return mask;
}

/// A gray ramp, with a target of 200 where it is.
cv::Mat image(int frame, const cv::Rect& target = kTarget) {
  cv::Mat gray(kSize, CV_8UC1);
  Rng rng(5, static_cast<std::uint64_t>(frame));
  for (int row = 0; row < gray.rows; ++row) {
    for (int column = 0; column < gray.cols; ++column) {
      const double level = target.contains({column, row}) ? 200.0 : 40.0 + column;
      gray.at<std::uint8_t>(row, column) =
          cv::saturate_cast<std::uint8_t>(level + kNoise * rng.normal());
    }
  }
  return gray;
}

BackgroundModel learned(int frames) {
  BackgroundModel model;
  for (int i = 0; i < frames; ++i) {
    learn_background(image(i), outline(), kNoise, &model);
  }
  return model;
}

/// Part of a box that matches.
double part_known(const cv::Mat& gray, BackgroundModel model, const cv::Rect& box) {
  match_background(gray, kNoise, &model);
  EXPECT_EQ(model.matches.size(), gray.size());
  return static_cast<double>(cv::countNonZero(model.matches(box))) / box.area();
}

TEST(BackgroundModel, KnowsWhatItSaw_WhereTheTargetStandsNow) {
  const BackgroundModel model = learned(8);
  const cv::Rect elsewhere(10, 10, 20, 20);
  EXPECT_GT(part_known(image(20), model, cv::Rect(5, 5, 30, 80)), 0.99);
  EXPECT_EQ(part_known(image(20, elsewhere), model, cv::Rect(11, 11, 18, 18)), 0.0);
}

TEST(BackgroundModel, IsEmpty_AfterAFewImages) {
  EXPECT_EQ(part_known(image(20), learned(3), kWhole), 0.0);
  EXPECT_EQ(part_known(image(20), {}, kWhole), 0.0);
}

TEST(BackgroundModel, DoesNotLearnTheTarget_NorWhatTheOutlineMayLackOfIt) {
  const BackgroundModel model = learned(30);
  const cv::Rect about(kTarget.x - kOutlineOff_px + 1,
                       kTarget.y - kOutlineOff_px + 1,
                       kTarget.width + 2 * kOutlineOff_px - 2,
                       kTarget.height + 2 * kOutlineOff_px - 2);
  EXPECT_EQ(part_known(image(40), model, about), 0.0);
}

TEST(BackgroundModel, ResetsAPlaceThatLooksDifferentForAsLong_AndLearnsItAgain) {
  BackgroundModel model = learned(40);
  const cv::Rect box(5, 5, 30, 30);  // something has been put down there
  const auto changed = [&](int frame) { return image(frame, box); };
  for (int i = 0; i < 10; ++i) {
    learn_background(changed(100 + i), outline(), kNoise, &model);
  }
  EXPECT_GT(part_known(image(50), model, box), 0.95);  // passed by, as a shadow
  for (int i = 10; i < 30; ++i) {
    learn_background(changed(100 + i), outline(), kNoise, &model);
  }
  EXPECT_LT(part_known(image(50), model, box), 0.01);
  EXPECT_GT(part_known(changed(200), model, cv::Rect(8, 8, 24, 24)), 0.99);
}

TEST(BackgroundModel, IsEmpty_OnceCleared) {
  BackgroundModel model = learned(20);
  clear(&model);
  EXPECT_EQ(part_known(image(20), model, kWhole), 0.0);
}

TEST(StandsStill, OnlyWhereAMotionLeavesTheImageWhereItWas) {
  const cv::Matx33d still = cv::Matx33d::eye();
  const cv::Matx33d shifted(1, 0, 0.8, 0, 1, 0, 0, 0, 1);
  const cv::Matx33d turned(1, -0.01, 0, 0.01, 1, 0, 0, 0, 1);
  BackgroundState background;
  EXPECT_FALSE(stands_still(background, kSize));
  (void)background.motions[0].layers.push_back(shifted);
  (void)background.motions[1].layers.push_back(turned);
  EXPECT_FALSE(stands_still(background, kSize));
  (void)background.motions[1].layers.push_back(still);
  EXPECT_TRUE(stands_still(background, kSize));
}

}  // namespace
}  // namespace polhode::background_model_test
