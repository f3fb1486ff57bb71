#include "initialisation/registration.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "textured_view.hpp"

namespace polhode::registration_test {
namespace {

using textured_view::View;

const Eigen::Vector2d kSpot(56.3, 47.6);

std::unique_ptr<Crop> whole(const cv::Mat& gray) {
  auto crops = std::make_unique<Crops>();
  const std::vector<Feature> corners = {
      {.u_px = 0.0F, .v_px = 0.0F},
      {.u_px = static_cast<float>(gray.cols - 1), .v_px = static_cast<float>(gray.rows - 1)}};
  keep_crop(gray, 1, corners, crops.get());
  return std::make_unique<Crop>(crops->kept[0]);
}

class RegisterPatch : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(make_template(*whole(textured_view::render({}, 1)), kSpot, &patch_));
  }
  /// From so far off the right place.
  std::optional<Registration> look(const View& view,
                                   const Eigen::Vector2d& off_px,
                                   const Eigen::Matrix2d& affine,
                                   std::uint64_t seed = 2) {
    return register_patch(
        patch_, *whole(textured_view::render(view, seed)), affine, view.place(kSpot) + off_px);
  }
  PatchTemplate patch_;
};

TEST_F(RegisterPatch, FindsThePlaceUnderAnotherMotionAndLight) {
  View view{.shift_px = {6.0, -9.0}, .gain = 0.6, .offset = 30.0};
  view.affine << 0.95, 0.12, -0.1, 0.9;
  const auto found = look(view, {0.7, -0.6}, Eigen::Matrix2d::Identity());
  ASSERT_TRUE(found);
  EXPECT_LT((found->place - view.place(kSpot)).norm(), 0.1);
  EXPECT_GT(found->zncc, 0.98);
}

TEST_F(RegisterPatch, ItsSigmaIsThatOfItsErrors) {
  double squares = 0.0;
  double reported = 0.0;
  constexpr int kTrials = 60;
  for (int trial = 0; trial < kTrials; ++trial) {
    const View view{.shift_px = {0.13 * trial, -0.07 * trial}, .gain = 0.7, .noise = 4.0};
    const auto found =
        look(view, {0.4, 0.3}, Eigen::Matrix2d::Identity(), static_cast<std::uint64_t>(trial) + 10);
    ASSERT_TRUE(found);
    squares += (found->place - view.place(kSpot)).squaredNorm() / 2.0;
    reported += found->sigma * found->sigma;
  }
  // Blur takes some of white noise out of the residuals, and the worse direction is reported:
  // within a factor of two.
  EXPECT_GT(std::sqrt(squares / reported), 0.5);
  EXPECT_LT(std::sqrt(squares / reported), 2.0);
}

TEST_F(RegisterPatch, OfAnotherSurfaceDoesNotCorrelate) {
  const View elsewhere{.shift_px = {21.0, 13.0}};
  const auto found = register_patch(patch_,
                                    *whole(textured_view::render(elsewhere, 3)),
                                    Eigen::Matrix2d::Identity(),
                                    kSpot + Eigen::Vector2d(4.0, -3.0));
  EXPECT_TRUE(!found || found->zncc < 0.75);
}

TEST_F(RegisterPatch, NothingIsFoundWhereTheWindowLeavesTheImage) {
  const auto crop = whole(textured_view::render({}, 2));
  EXPECT_FALSE(register_patch(patch_, *crop, Eigen::Matrix2d::Identity(), {3.0, 40.0}));
  EXPECT_FALSE(register_patch(patch_, *crop, Eigen::Matrix2d::Identity(), {1e9, -1e9}));
}

TEST_F(RegisterPatch, AFlatImageIsNoMatch) {
  const auto crop = whole(cv::Mat(100, 120, CV_8UC1, cv::Scalar(90.0)));
  EXPECT_FALSE(register_patch(patch_, *crop, Eigen::Matrix2d::Identity(), kSpot));
}

TEST(MakeTemplate, RefusesWhatDoesNotFixAPlace) {
  PatchTemplate patch;
  const auto edges = whole(textured_view::render({.noise = 0.0}, 1, true));
  EXPECT_FALSE(make_template(*edges, kSpot, &patch)) << "edges of one direction";
  const auto flat = whole(cv::Mat(100, 120, CV_8UC1, cv::Scalar(90.0)));
  EXPECT_FALSE(make_template(*flat, kSpot, &patch));
  const auto textured = whole(textured_view::render({}, 1));
  EXPECT_FALSE(make_template(*textured, {4.0, 50.0}, &patch)) << "beyond the picture's border";
  EXPECT_FALSE(make_template(Crop{}, kSpot, &patch));
}

}  // namespace
}  // namespace polhode::registration_test
