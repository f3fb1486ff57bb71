#include "image/exposure.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/rng.hpp"

namespace polhode::exposure_test {
namespace {

/// A target's radiances: most between a tenth and one, a few glints of up to five.
std::vector<double> radiances() {
  Rng rng(3, 0);
  std::vector<double> out;
  for (int i = 0; i < 5000; ++i) {
    out.push_back(i % 100 == 0 ? 5.0 * rng.uniform() : 0.1 + 0.9 * rng.uniform());
  }
  return out;
}

/// What a camera makes of them: full scale at radiance * exposure * gain = 0.01.
LevelCounts expose(const std::vector<double>& radiance, const Exposure& e, double gamma) {
  LevelCounts counts{};
  for (const double r : radiance) {
    const double level = std::pow(std::min(1.0, r * e.exposure_s * e.gain / 0.01), 1.0 / gamma);
    ++counts[static_cast<std::size_t>(std::lround(255.0 * level))];
  }
  return counts;
}

double saturated(const LevelCounts& counts) {
  double sum = 0.0;
  double high = 0.0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    sum += counts[i];
    high += i >= 250 ? counts[i] : 0.0;
  }
  return high / sum;
}

// verifies: IMG-06
TEST(NextExposure, SettlesBelowSaturation_FromAnyStart_WithEitherResponse) {
  const auto target = radiances();
  for (const double gamma : {1.0, 2.2}) {
    const ExposureRange range{.response_gamma = gamma};
    for (const double start_s : {1e-5, 1e-4, 1e-3, 1e-2, 0.1}) {
      Exposure e{.exposure_s = start_s};
      for (int i = 0; i < 20; ++i) {
        e = next_exposure(expose(target, e, gamma), e, 0.0, range, {});
      }
      EXPECT_LT(saturated(expose(target, e, gamma)), 0.02) << start_s;
      // The body's brightest ordinary radiance, 1, ends up near 0.8 of full scale.
      EXPECT_NEAR(std::pow(e.exposure_s * e.gain / 0.01, 1.0 / gamma), 0.8, 0.1) << start_s;
    }
  }
}

TEST(NextExposure, ComesToRest) {
  const auto target = radiances();
  Exposure e{.exposure_s = 0.05};
  for (int i = 0; i < 20; ++i) {
    e = next_exposure(expose(target, e, 1.0), e, 0.0, {}, {});
  }
  const Exposure settled = e;
  for (int i = 0; i < 5; ++i) {
    e = next_exposure(expose(target, e, 1.0), e, 0.0, {}, {});
    EXPECT_EQ(e.exposure_s, settled.exposure_s);
    EXPECT_EQ(e.gain, settled.gain);
  }
}

// verifies: IMG-05
TEST(NextExposure, TakesBoundedSteps_WithinTheRange_WhateverTheHistogram) {
  Rng rng(9, 0);
  const ExposureRange range;
  for (int trial = 0; trial < 2000; ++trial) {
    LevelCounts counts{};
    for (int i = 0; i < 20; ++i) {
      counts[rng.below(256)] += rng.below(1000);
    }
    const Exposure now{.exposure_s = std::pow(10.0, -5.0 + 4.0 * rng.uniform()),
                       .gain = 1.0 + 15.0 * rng.uniform()};
    const double motion_px_s = trial % 3 == 0 ? 0.0 : 1000.0 * rng.uniform();
    const Exposure next = next_exposure(counts, now, motion_px_s, range, {});
    EXPECT_GE(next.exposure_s, range.exposure_min_s);
    EXPECT_LE(next.exposure_s, range.exposure_max_s);
    EXPECT_GE(next.gain, range.gain_min);
    EXPECT_LE(next.gain, range.gain_max);
    EXPECT_LE(next.exposure_s * next.gain,
              2.0 * now.exposure_s * now.gain * (1.0 + 1e-12) + range.exposure_min_s);
    if (motion_px_s > 0.0) {
      EXPECT_LE(next.exposure_s * motion_px_s,
                std::max(0.5, range.exposure_min_s * motion_px_s) + 1e-9);
    }
  }
}

TEST(NextExposure, TradesExposureForGain_WhereTheImageMoves) {
  const auto target = radiances();
  Exposure still{.exposure_s = 8e-3};
  Exposure moving = still;
  for (int i = 0; i < 20; ++i) {
    still = next_exposure(expose(target, still, 1.0), still, 0.0, {}, {});
    moving = next_exposure(expose(target, moving, 1.0), moving, 250.0, {}, {});
  }
  EXPECT_EQ(still.gain, 1.0);
  EXPECT_NEAR(moving.exposure_s, 0.5 / 250.0, 1e-12);
  EXPECT_NEAR(moving.exposure_s * moving.gain, still.exposure_s, 0.1 * still.exposure_s);
}

TEST(NextExposure, StaysAsItIs_WithoutATarget) {
  const Exposure now{.exposure_s = 3e-3, .gain = 2.0};
  const Exposure next = next_exposure({}, now, 0.0, {}, {});
  EXPECT_EQ(next.exposure_s, now.exposure_s);
  EXPECT_EQ(next.gain, now.gain);
}

}  // namespace
}  // namespace polhode::exposure_test
