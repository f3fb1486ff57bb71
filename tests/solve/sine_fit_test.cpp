#include "solve/sine_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "base/rng.hpp"

namespace polhode::sine_fit_test {
namespace {

constexpr double kTau = 2.0 * std::numbers::pi;

std::vector<SineSample> sine_samples(
    double period_s, double amplitude, double sigma, int count, std::uint64_t seed) {
  Rng rng(seed, 3);
  std::vector<SineSample> samples;
  // Differences of noisy angles, as they come from poses: intervals of 10 s that touch.
  double previous = sigma * 10.0 / std::sqrt(2.0) * rng.normal();
  for (int i = 0; i < count; ++i) {
    const double t = 10.0 * i + 5.0;
    const double next = sigma * 10.0 / std::sqrt(2.0) * rng.normal();
    const double half = 0.5 * kTau / period_s * 10.0;
    const double mean =
        amplitude * std::sin(kTau * (t - 5.0) / period_s + 0.7) * std::sin(half) / half;
    samples.push_back({.time_s = t,
                       .value = 0.3 + mean + (next - previous) / 10.0,
                       .sigma = sigma,
                       .interval_s = 10.0});
    previous = next;
  }
  return samples;
}

TEST(Sine, IsFoundWithHonestSigmas) {
  int beyond = 0;
  double square = 0.0;
  constexpr int kSeeds = 100;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Result<SineFit> fit = fit_sine(sine_samples(376.0, 0.1, 0.03, 299, seed));
    ASSERT_TRUE(fit.ok());
    ASSERT_TRUE(fit.value().observed);
    const double z = (fit.value().period_s - 376.0) / fit.value().sigma_period_s;
    beyond += std::abs(z) > 1.96 ? 1 : 0;
    square += z * z;
    EXPECT_NEAR(fit.value().amplitude, 0.1, 5.0 * fit.value().sigma_amplitude);
    EXPECT_NEAR(fit.value().offset, 0.3, 5.0 * fit.value().sigma_offset);
    EXPECT_NEAR(fit.value().phase_rad, 0.7, 5.0 * fit.value().sigma_phase_rad);
  }
  // 5 expected, standard deviation 2.2.
  EXPECT_LE(beyond, 12);
  EXPECT_GT(square / kSeeds, 0.25);
}

TEST(Sine, IsExactWithoutNoise) {
  std::vector<SineSample> samples = sine_samples(150.0, 0.2, 1e-9, 100, 1);
  const Result<SineFit> fit = fit_sine(samples);
  ASSERT_TRUE(fit.ok());
  EXPECT_NEAR(fit.value().period_s, 150.0, 1e-5);
  EXPECT_NEAR(fit.value().amplitude, 0.2, 1e-7);
  EXPECT_NEAR(fit.value().phase_rad, 0.7, 1e-6);
}

TEST(Sine, IsNotSeenInNoiseNorInLessThanAPeriod) {
  int seen = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    seen += fit_sine(sine_samples(376.0, 0.0, 0.03, 100, seed)).value().observed ? 1 : 0;
  }
  EXPECT_LE(seen, 2);
  EXPECT_FALSE(fit_sine(sine_samples(3000.0, 0.1, 0.001, 100, 1)).value().observed);
}

TEST(Sine, OfTooFewOrUnusableSamplesIsAnError) {
  EXPECT_EQ(fit_sine({}).error().code, ErrorCode::kTooFewObservations);
  std::vector<SineSample> samples = sine_samples(100.0, 0.1, 0.01, 20, 1);
  samples[4].sigma = 0.0;
  EXPECT_EQ(fit_sine(samples).error().code, ErrorCode::kDegenerate);
  for (SineSample& sample : samples)
    sample = {.time_s = 1.0, .value = 1.0, .sigma = 1.0, .interval_s = 0.0};
  EXPECT_EQ(fit_sine(samples).error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace polhode::sine_fit_test
