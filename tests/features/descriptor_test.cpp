#include "features/descriptor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "features/match.hpp"
#include "features/orientation.hpp"
#include "features/patch.hpp"

namespace polhode::sift::descriptor_test {
namespace {

constexpr int kSide = 121;
constexpr float kMiddle = 60.0F;
constexpr float kPi = std::numbers::pi_v<float>;

/// An image given by a formula of (x, y) about its middle, turned by an angle.
template <typename Formula>
std::vector<float> draw(double turn_rad, const Formula& formula) {
  std::vector<float> memory(static_cast<std::size_t>(stride_of(kSide) * kSide));
  const double c = std::cos(turn_rad);
  const double s = std::sin(turn_rad);
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double dx = x - static_cast<double>(kMiddle);
      const double dy = y - static_cast<double>(kMiddle);
      memory[static_cast<std::size_t>(y * stride_of(kSide) + x)] =
          static_cast<float>(formula(c * dx + s * dy, c * dy - s * dx));
    }
  }
  return memory;
}

Plane plane_of(std::vector<float>* memory) {
  return {.data = memory->data(), .width = kSide, .height = kSide, .stride = stride_of(kSide)};
}

/// Waves without any symmetry, pointing mostly along x.
double waves(double x, double y) {
  return 100.0 + 4.0 * x + 20.0 * std::sin(0.31 * x + 0.2) + 15.0 * std::sin(0.23 * y + 0.11 * x) +
         9.0 * std::cos(0.41 * y - 0.17 * x + 1.0);
}

TEST(SampleGradients, HasTheLengthAndDirectionOfARamp_InTheFrameOfThePatch) {
  for (int degrees = 0; degrees < 360; degrees += 7) {
    SCOPED_TRACE(degrees);
    const double ramp_rad = degrees * std::numbers::pi / 180.0;
    auto memory = draw(ramp_rad, [](double x, double) { return 300.0 + 2.0 * x; });
    for (const float frame_rad : {0.0F, 0.7F, 4.0F}) {
      Gradients<16> gradients;
      constexpr float kStep = 1.3F;
      sample_gradients(plane_of(&memory),
                       {.x = kMiddle + 0.3F,
                        .y = kMiddle - 0.4F,
                        .step_x = kStep * std::cos(frame_rad),
                        .step_y = kStep * std::sin(frame_rad)},
                       &gradients);
      for (std::size_t k = 0; k < Gradients<16>::kCount; ++k) {
        EXPECT_NEAR(gradients.length[k], 2.0F * 2.0F * kStep, 1e-3F);
        EXPECT_GE(gradients.angle_rad[k], 0.0F);
        EXPECT_LE(gradients.angle_rad[k], 2.0F * kPi);
        const double expected_rad = ramp_rad - static_cast<double>(frame_rad);
        // Single precision of levels up to 500 leaves 1e-4 rad; the polynomial 1e-5.
        EXPECT_NEAR(std::remainder(static_cast<double>(gradients.angle_rad[k]) - expected_rad,
                                   2.0 * std::numbers::pi),
                    0.0,
                    3e-4);
      }
    }
  }
}

TEST(SampleGradients, ReadsNothingOutsideTheImage) {
  // On the heap, where the address sanitizer watches.
  auto memory = draw(0.0, waves);
  for (const float x : {0.0F, kSide - 1.0F}) {
    for (const float y : {0.0F, kSide - 1.0F}) {
      Gradients<12> gradients;
      sample_gradients(
          plane_of(&memory), {.x = x, .y = y, .step_x = 5.0F, .step_y = 9.0F}, &gradients);
      for (const float length : gradients.length) {
        EXPECT_TRUE(std::isfinite(length));
      }
    }
  }
}

TEST(FindOrientations, FollowsTheImage) {
  for (int degrees = 0; degrees < 360; degrees += 15) {
    SCOPED_TRACE(degrees);
    auto memory =
        draw(degrees * std::numbers::pi / 180.0, [](double x, double) { return 100.0 + 2.0 * x; });
    Orientations found;
    find_orientations(plane_of(&memory), kMiddle, kMiddle, 2.0F, &found);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NEAR(std::remainder(static_cast<double>(found[0]) - degrees * std::numbers::pi / 180.0,
                               2.0 * std::numbers::pi),
                0.0,
                2e-3);
  }
}

TEST(FindOrientations, FindsBothOfTwo_AndNoneWhereNothingIs) {
  auto ridge = draw(0.4, [](double x, double) { return 100.0 - 2.0 * std::abs(x); });
  Orientations found;
  find_orientations(plane_of(&ridge), kMiddle, kMiddle, 2.0F, &found);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[1] - found[0], kPi, 0.02F);
  auto flat = draw(0.0, [](double, double) { return 100.0; });
  find_orientations(plane_of(&flat), kMiddle, kMiddle, 2.0F, &found);
  EXPECT_TRUE(found.empty());
}

TEST(Describe, IsTheSame_WhateverTheTurnTheSizeAndTheLight) {
  auto memory = draw(0.0, waves);
  const Descriptor upright =
      compute_descriptor(plane_of(&memory), {.x = kMiddle, .y = kMiddle, .sigma_px = 2.0F});
  // Two views of one spot differ by about 200 in real images; bilinear samples of these waves by
  // far less.
  constexpr int kSame2 = 40 * 40;
  for (const double turn_rad : {0.3, 1.0, 2.5, 5.0}) {
    auto turned = draw(turn_rad, waves);
    const Descriptor d = compute_descriptor(
        plane_of(&turned),
        {.x = kMiddle, .y = kMiddle, .sigma_px = 2.0F, .angle_rad = static_cast<float>(turn_rad)});
    EXPECT_LT(distance2(upright, d), kSame2) << turn_rad;
  }
  auto larger = draw(0.0, [](double x, double y) { return waves(x / 1.3, y / 1.3); });
  EXPECT_LT(distance2(upright,
                      compute_descriptor(plane_of(&larger),
                                         {.x = kMiddle, .y = kMiddle, .sigma_px = 2.6F})),
            kSame2);
  auto darker = draw(0.0, [](double x, double y) { return 0.3 * waves(x, y) + 7.0; });
  EXPECT_LT(distance2(upright,
                      compute_descriptor(plane_of(&darker),
                                         {.x = kMiddle, .y = kMiddle, .sigma_px = 2.0F})),
            4 * 4);
}

TEST(Describe, SeparatesPlaces_AndIsZeroWhereNothingIs) {
  auto memory = draw(0.0, waves);
  const Descriptor here =
      compute_descriptor(plane_of(&memory), {.x = kMiddle, .y = kMiddle, .sigma_px = 2.0F});
  const Descriptor there = compute_descriptor(
      plane_of(&memory), {.x = kMiddle + 9.0F, .y = kMiddle - 7.0F, .sigma_px = 2.0F});
  EXPECT_GT(distance2(here, there), 100 * 100);
  auto flat = draw(0.0, [](double, double) { return 100.0; });
  EXPECT_EQ(compute_descriptor(plane_of(&flat), {.x = kMiddle, .y = kMiddle, .sigma_px = 2.0F}),
            Descriptor{});
}

TEST(Describe, HasNorm512) {
  auto memory = draw(0.0, waves);
  const Descriptor d =
      compute_descriptor(plane_of(&memory), {.x = kMiddle, .y = kMiddle, .sigma_px = 2.0F});
  // Rounding to whole numbers moves each of 128 values by up to a half.
  EXPECT_NEAR(
      std::sqrt(static_cast<double>(distance2(d, Descriptor{}))), 512.0, 0.5 * std::sqrt(128.0));
}

}  // namespace
}  // namespace polhode::sift::descriptor_test
