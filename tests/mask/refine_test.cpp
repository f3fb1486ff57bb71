#include "mask/refine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace polhode {
namespace {

constexpr std::size_t kPixels = std::size_t{MaskNetwork::kSide_px} * MaskNetwork::kSide_px;
const cv::Rect kBody(40, 30, 60, 50);
const cv::Size kSize(160, 120);

/// A network that says the same everywhere, and remembers what it was shown.
struct Constant {
  float answer = 0.0F;
  bool answers = true;
  int asked = 0;
  float outline_middle = -1.0F;
  float outline_corner = -1.0F;
  float gray_middle = -1.0F;

  static bool ask(void* context, const float* gray, const float* outline, float* target) {
    auto* self = static_cast<Constant*>(context);
    ++self->asked;
    const std::size_t middle = kPixels / 2 + MaskNetwork::kSide_px / 2;
    self->gray_middle = gray[middle];
    self->outline_middle = outline[middle];
    self->outline_corner = outline[0];
    std::fill_n(target, kPixels, self->answer);
    return self->answers;
  }
};

cv::Mat refined(Constant* network, const cv::Mat& outline) {
  const cv::Mat picture(kSize, CV_8UC1, cv::Scalar(51));
  cv::Mat unary_cost(kSize, CV_32FC1, cv::Scalar(0.25));
  RefineScratch scratch;
  refine_unary_cost(
      picture, outline, {.ask = Constant::ask, .context = network}, 1, &scratch, &unary_cost);
  return unary_cost;
}

cv::Mat body() {
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(0));
  outline(kBody).setTo(255);
  return outline;
}

bool untouched(const cv::Mat& unary_cost) {
  return cv::norm(unary_cost, cv::Mat(kSize, CV_32FC1, cv::Scalar(0.25)), cv::NORM_INF) == 0.0;
}

TEST(RefineUnaryCost, ShowsThePictureAndTheOutline) {
  Constant network;
  refined(&network, body());
  EXPECT_EQ(network.asked, 1);
  EXPECT_FLOAT_EQ(network.gray_middle, 0.2F);
  EXPECT_FLOAT_EQ(network.outline_middle, 1.0F);
  EXPECT_FLOAT_EQ(network.outline_corner, 0.0F);
}

TEST(RefineUnaryCost, ShiftsTheCostAroundTheOutline_AndNothingFarFromIt) {
  for (const float answer : {0.0F, 0.5F, 1.0F}) {
    Constant network{.answer = answer};
    const cv::Mat unary_cost = refined(&network, body());
    const float moved = unary_cost.at<float>(55, 70) - 0.25F;
    EXPECT_NEAR(moved, 1.8F * (answer - 0.5F), 1e-5F);
    EXPECT_EQ(unary_cost.at<float>(119, 159), 0.25F);
  }
}

TEST(RefineUnaryCost, ShiftsACostByCells) {
  Constant network{.answer = 1.0F};
  const cv::Mat picture(kSize, CV_8UC1, cv::Scalar(51));
  cv::Mat unary_cost(kSize / 2, CV_32FC1, cv::Scalar(0.25));
  RefineScratch scratch;
  refine_unary_cost(
      picture, body(), {.ask = Constant::ask, .context = &network}, 2, &scratch, &unary_cost);
  EXPECT_NEAR(unary_cost.at<float>(27, 35), 0.25F + 0.9F, 1e-5F);
  EXPECT_EQ(unary_cost.at<float>(59, 79), 0.25F);
}

// verifies: MSK-05
TEST(RefineUnaryCost, LeavesTheCost_WhereTheNetworkHasNoAnswerOrAWrongOne) {
  Constant silent{.answer = 1.0F, .answers = false};
  EXPECT_TRUE(untouched(refined(&silent, body())));
  for (const float nonsense : {std::numeric_limits<float>::quiet_NaN(),
                               std::numeric_limits<float>::infinity(),
                               -0.5F,
                               7.0F}) {
    Constant network{.answer = nonsense};
    EXPECT_TRUE(untouched(refined(&network, body()))) << nonsense;
  }
}

TEST(RefineUnaryCost, AsksNothing_WithoutAnOutlineOrANetwork) {
  Constant network{.answer = 1.0F};
  EXPECT_TRUE(untouched(refined(&network, cv::Mat(kSize, CV_8UC1, cv::Scalar(0)))));
  EXPECT_EQ(network.asked, 0);
  cv::Mat unary_cost(kSize, CV_32FC1, cv::Scalar(0.25));
  RefineScratch scratch;
  refine_unary_cost(cv::Mat(kSize, CV_8UC1, cv::Scalar(9)), body(), {}, 1, &scratch, &unary_cost);
  EXPECT_TRUE(untouched(unary_cost));
}

}  // namespace
}  // namespace polhode
