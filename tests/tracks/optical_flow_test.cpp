#include "tracks/optical_flow.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "base/rng.hpp"

namespace polhode::optical_flow_test {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

struct Wave {
  double fu_rad_px = 0.0;
  double fv_rad_px = 0.0;
  double phase_rad = 0.0;
};

/// A sum of waves of 8 to 60 px: band-limited, so that it can be sampled exactly at any shift.
cv::Mat texture(std::uint64_t seed, double shift_u_px, double shift_v_px) {
  Rng rng(seed, 31);
  std::vector<Wave> waves;
  for (int i = 0; i < 40; ++i) {
    const double frequency = 2.0 * std::numbers::pi / (8.0 * std::pow(7.5, rng.uniform()));
    const double direction = 2.0 * std::numbers::pi * rng.uniform();
    waves.push_back({frequency * std::cos(direction),
                     frequency * std::sin(direction),
                     2.0 * std::numbers::pi * rng.uniform()});
  }
  cv::Mat gray(kHeight, kWidth, CV_8UC1);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      double sum = 0.0;
      for (const Wave& w : waves) {
        sum +=
            std::cos(w.fu_rad_px * (u - shift_u_px) + w.fv_rad_px * (v - shift_v_px) + w.phase_rad);
      }
      gray.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(128.0 + 12.0 * sum);
    }
  }
  return gray;
}

Pyramid pyramid_of(const cv::Mat& gray) {
  Pyramid pyramid;
  build_pyramid(gray, &pyramid);
  return pyramid;
}

std::vector<FlowPoint> grid_of_points() {
  std::vector<FlowPoint> points;
  for (int v = 50; v <= kHeight - 50; v += 20) {
    for (int u = 50; u <= kWidth - 50; u += 20) {
      points.push_back(
          {.u_px = static_cast<float>(u) + 0.3F, .v_px = static_cast<float>(v) - 0.2F});
    }
  }
  return points;
}

void expect_followed(double shift_u_px, double shift_v_px, double guess_error_px) {
  const Pyramid before = pyramid_of(texture(1, 0.0, 0.0));
  const Pyramid now = pyramid_of(texture(1, shift_u_px, shift_v_px));
  const std::vector<FlowPoint> from = grid_of_points();
  std::vector<FlowPoint> to = from;
  for (FlowPoint& p : to) {
    p.u_px += static_cast<float>(shift_u_px + guess_error_px);
    p.v_px += static_cast<float>(shift_v_px - guess_error_px);
  }
  follow_points(before, now, from, {}, to);
  for (std::size_t i = 0; i < from.size(); ++i) {
    EXPECT_TRUE(to[i].followed) << i;
    // Rounding to 256 levels with a contrast near 50 over 21 x 21 px leaves about 1e-3 px; the step
    // rule stops at 0.01.
    EXPECT_NEAR(static_cast<double>(to[i].u_px - from[i].u_px), shift_u_px, 0.05) << i;
    EXPECT_NEAR(static_cast<double>(to[i].v_px - from[i].v_px), shift_v_px, 0.05) << i;
  }
}

TEST(FollowPoints, StaysInPlace_WhenTheImageDoes) { expect_followed(0.0, 0.0, 0.0); }

// verifies: TRK-01
TEST(FollowPoints, FindsAShiftOfAPartOfAPixel) { expect_followed(0.37, -0.61, 0.0); }

// verifies: TRK-01
TEST(FollowPoints, FindsALargeShift_WhenTheGuessIsNear) { expect_followed(23.4, -17.7, 2.0); }

TEST(FollowPoints, FindsAShiftOfSomePixels_WithoutAGuess) {
  const std::vector<FlowPoint> from = grid_of_points();
  std::vector<FlowPoint> to = from;
  follow_points(pyramid_of(texture(1, 0.0, 0.0)), pyramid_of(texture(1, 4.3, 3.2)), from, {}, to);
  for (std::size_t i = 0; i < from.size(); ++i) {
    EXPECT_TRUE(to[i].followed);
    EXPECT_NEAR(static_cast<double>(to[i].u_px - from[i].u_px), 4.3, 0.05);
  }
}

// verifies: TRK-02
TEST(FollowPoints, SurvivesAChangeOfBrightnessOfSomePercent) {
  cv::Mat brighter;
  texture(1, 2.5, 0.0).convertTo(brighter, CV_8UC1, 1.03, 2.0);
  const std::vector<FlowPoint> from = grid_of_points();
  std::vector<FlowPoint> to = from;
  follow_points(pyramid_of(texture(1, 0.0, 0.0)), pyramid_of(brighter), from, {}, to);
  int followed = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    followed += to[i].followed ? 1 : 0;
    if (to[i].followed) {
      // A constant offset b of the patch biases the step by b times the mean gradient over the mean
      // squared gradient: some tenths of a pixel for 2 to 5 levels against gradients of about 10
      // levels a pixel.
      EXPECT_NEAR(static_cast<double>(to[i].u_px - from[i].u_px), 2.5, 0.3);
    }
  }
  EXPECT_GE(followed, static_cast<int>(9 * from.size() / 10));
}

TEST(FollowPoints, LosesMostPoints_WhenTheImagesHaveNothingInCommon) {
  const std::vector<FlowPoint> from = grid_of_points();
  std::vector<FlowPoint> to = from;
  follow_points(pyramid_of(texture(1, 0.0, 0.0)), pyramid_of(texture(2, 0.0, 0.0)), from, {}, to);
  const auto followed =
      std::count_if(to.begin(), to.end(), [](const FlowPoint& p) { return p.followed; });
  EXPECT_LE(followed, static_cast<std::ptrdiff_t>(from.size() / 5));
}

TEST(FollowPoints, LosesEveryPoint_OnUniformImages) {
  cv::Mat gray(kHeight, kWidth, CV_8UC1);
  gray.setTo(90);
  const std::vector<FlowPoint> from = grid_of_points();
  std::vector<FlowPoint> to = from;
  follow_points(pyramid_of(gray), pyramid_of(gray), from, {}, to);
  for (const FlowPoint& p : to) {
    EXPECT_FALSE(p.followed);
  }
}

TEST(FollowPoints, LosesPointsThatLeaveTheImage) {
  const std::vector<FlowPoint> from{{.u_px = 160.0F, .v_px = 120.0F}};
  std::vector<FlowPoint> to{{.u_px = 500.0F, .v_px = 120.0F}};
  follow_points(pyramid_of(texture(1, 0.0, 0.0)), pyramid_of(texture(1, 340.0, 0.0)), from, {}, to);
  EXPECT_FALSE(to[0].followed);
}

TEST(FollowPoints, DoesNothing_WithoutPoints) {
  const Pyramid pyramid = pyramid_of(texture(1, 0.0, 0.0));
  follow_points(pyramid, pyramid, {}, {}, {});
}

TEST(FollowPoints, KeepsFewerPoints_WhenTheWayBackHasToBeCloser) {
  const Pyramid before = pyramid_of(texture(1, 0.0, 0.0));
  cv::Mat mixed = texture(1, 1.3, 0.4);
  mixed = 0.5 * mixed + 0.5 * texture(2, 0.0, 0.0);
  const std::vector<FlowPoint> from = grid_of_points();
  std::ptrdiff_t kept[2] = {0, 0};
  const double limit_px[2] = {0.05, 2.0};
  for (int i = 0; i < 2; ++i) {
    std::vector<FlowPoint> to = from;
    follow_points(before, pyramid_of(mixed), from, {.forward_backward_max_px = limit_px[i]}, to);
    kept[i] = std::count_if(to.begin(), to.end(), [](const FlowPoint& p) { return p.followed; });
  }
  EXPECT_LT(kept[0], kept[1]);
}

}  // namespace
}  // namespace polhode::optical_flow_test
