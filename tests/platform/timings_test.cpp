#include "app/timings.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace polhode::platform::timings_test {
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

TEST(Timings, AStageThatAStepReturnsToIsOneSample_OfAllThatItSpentOnIt) {
  Timings timings(1);
  timings.start_step();
  for (int visit = 0; visit < 2; ++visit) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    Timings::hook(&timings, Stage::kMask);
    Timings::hook(&timings, Stage::kMap);
  }
  (void)timings.end_step();
  const auto samples_us = [&](Stage stage) {
    return timings.stages[static_cast<std::size_t>(stage)].samples_us;
  };
  ASSERT_EQ(samples_us(Stage::kMask).size(), 1U);
  EXPECT_GE(samples_us(Stage::kMask).front(), 40000U);
  ASSERT_EQ(samples_us(Stage::kMap).size(), 1U);
  EXPECT_LT(samples_us(Stage::kMap).front(), samples_us(Stage::kMask).front());
}

TEST(Timings, WaitingCostsTimeAndNoProcessorTime) {
  Timings timings(1);
  timings.start_step();
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  Timings::hook(&timings, Stage::kImage);
  (void)timings.end_step();
  const auto image = static_cast<std::size_t>(Stage::kImage);
  EXPECT_GE(timings.stages[image].samples_us.at(0), 30000U);
  EXPECT_LT(timings.stages_cpu[image].samples_us.at(0), 10000U);
  EXPECT_GE(timings.step.samples_us.at(0), 30000U);
  EXPECT_LT(timings.step_cpu.samples_us.at(0), 10000U);
}

}  // namespace
}  // namespace polhode::platform::timings_test
