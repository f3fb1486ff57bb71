#include "app/timings.hpp"

#include <gtest/gtest.h>

namespace polhode::platform {
namespace {

TEST(Durations, PercentilesAreNearestRanks) {
  Durations durations;
  EXPECT_EQ(durations.percentile_us(0.5), 0U);
  for (int us = 100; us >= 1; --us) {
    durations.add(std::chrono::microseconds(us));
  }
  EXPECT_EQ(durations.percentile_us(0.50), 50U);
  EXPECT_EQ(durations.percentile_us(0.95), 95U);
  EXPECT_EQ(durations.percentile_us(0.99), 99U);
  EXPECT_EQ(durations.percentile_us(1.0), 100U);
}

TEST(Timings, EveryStageOfAStepIsOneSample) {
  Timings timings(2);
  for (int step = 0; step < 2; ++step) {
    timings.start_step();
    Timings::hook(&timings, Stage::kImage);
    Timings::hook(&timings, Stage::kBus);
    EXPECT_GE(timings.end_step(), 0);
  }
  EXPECT_EQ(timings.step.samples_us.size(), 2U);
  EXPECT_EQ(timings.stages[static_cast<std::size_t>(Stage::kBus)].samples_us.size(), 2U);
  EXPECT_EQ(timings.stages[static_cast<std::size_t>(Stage::kMask)].samples_us.size(), 0U);
}

}  // namespace
}  // namespace polhode::platform
