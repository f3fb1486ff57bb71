#include "app/live_counts.hpp"

#include "app/live_report.hpp"

#include <gtest/gtest.h>

namespace polhode::platform::live_counts_test {
namespace {

TEST(DurationHistogram, KnowsPercentilesToFivePerCent) {
  DurationHistogram histogram;
  for (std::int64_t us = 1; us <= 100'000; ++us) {
    histogram.add(1000 * us);
  }
  for (const double fraction : {0.001, 0.5, 0.95, 0.99}) {
    const double truth = fraction * 100'000;
    EXPECT_GE(static_cast<double>(histogram.percentile_us(fraction)), truth);
    EXPECT_LE(static_cast<double>(histogram.percentile_us(fraction)), 1.07 * truth);
  }
  EXPECT_EQ(histogram.max_us(), 100'000U);
  EXPECT_EQ(histogram.percentile_us(1.0), 100'000U);
  EXPECT_NEAR(histogram.mean_us(), 50'000.5, 1e-6);
}

TEST(DurationHistogram, TakesAnything) {
  DurationHistogram histogram;
  EXPECT_EQ(histogram.percentile_us(0.99), 0U);
  histogram.add(-5);
  histogram.add(0);
  EXPECT_EQ(histogram.percentile_us(0.99), 0U);
  histogram.add(INT64_MAX);
  EXPECT_EQ(histogram.max_us(), static_cast<std::uint64_t>(INT64_MAX / 1000));
  EXPECT_EQ(histogram.count(), 3U);
}

TEST(FramesPassedOver, CountAllThatTheComponentNeverSaw) {
  CameraCounters camera;
  camera.frames_late = 2;
  camera.frames_out_of_time = 3;
  camera.frames_damaged = 100;  // answered with a packet
  LiveCounts counts;
  counts.frames_dropped_for_job = 12;
  EXPECT_EQ(frames_passed_over(camera, counts), 17U);
}

}  // namespace
}  // namespace polhode::platform::live_counts_test
