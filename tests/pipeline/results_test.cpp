#include "pipeline/results.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "job_caller.hpp"

namespace polhode::results_test {
namespace {

using namespace bench;

constexpr JobOptions kLongOnesBeside{.delay_frames = 0, .delay_of_all_frames = 1};

TEST(Jobs, WithoutDelay_AreDoneWithinTheStep) {
  Caller& caller = shown(delayed(0), Run::kWhenDue);
  EXPECT_EQ(caller.jobs(), 0);
  EXPECT_GT(caller.component().counters().jobs_issued, 3U);
  EXPECT_EQ(state_of(caller.component()).mode.now, Mode::kTracking);
}

class JobsWithDelay : public ::testing::TestWithParam<JobOptions> {};

// verifies: CMP-02
TEST_P(JobsWithDelay, PacketsDoNotShowWhenAJobWasRun) {
  Caller& early = shown(GetParam(), Run::kAtOnce);
  Caller& late = shown(GetParam(), Run::kWhenDue);
  EXPECT_GT(early.jobs(), 3);
  EXPECT_EQ(early.packets(), shown(GetParam(), Run::kAtRandom).packets());
  EXPECT_EQ(early.jobs(), late.jobs());
  EXPECT_EQ(early.packets(), late.packets());
}

TEST_P(JobsWithDelay, TheBodyIsAcquiredAndFollowed) {
  Caller& caller = shown(GetParam(), Run::kWhenDue);
  EXPECT_EQ(state_of(caller.component()).mode.now, Mode::kTracking);
  EXPECT_EQ(caller.component().counters().lost, 0U);
  EXPECT_GT(state_of(caller.component()).mapping.map.keyframe_count, 3);
}

// verifies: CMP-02
TEST_P(JobsWithDelay, AJobNamesTheStepThatTakesItsResult) {
  Caller caller(parameters(), GetParam(), Run::kAtOnce);
  std::uint32_t step = 0;
  for (const Picture& picture : turning_ball()) {
    const StepOutput& out = caller.show(picture);
    for (const Job* job : out.jobs) {
      EXPECT_EQ(due_step(*job),
                step + static_cast<std::uint32_t>(std::max(1, GetParam().delay_frames)));
    }
    ++step;
  }
}

TEST_P(JobsWithDelay, TheEndOfARunTakesInWhatIsStillOut) {
  Caller caller(parameters(), GetParam(), Run::kAtOnce);
  for (const Picture& picture : turning_ball()) {
    if (caller.jobs() > 2 && caller.out<AdjustmentJob>() != nullptr) {
      break;
    }
    (void)caller.show(picture);
  }
  ASSERT_NE(caller.out<AdjustmentJob>(), nullptr);
  close_jobs(&state_of(caller.component()));
  EXPECT_FALSE(is_out(state_of(caller.component()).jobs.map));
}

INSTANTIATE_TEST_SUITE_P(Delays,
                         JobsWithDelay,
                         ::testing::Values(delayed(1), delayed(3), kLongOnesBeside));

TEST(Jobs, WindowsAreAdjustedWithinTheStepWhileLongWorkIsBesideIt) {
  Caller caller(parameters(), kLongOnesBeside, Run::kWhenDue);
  int windows = 0;
  int long_ones = 0;
  for (const Picture& picture : turning_ball()) {
    const std::uint32_t issued = caller.state().counters.jobs_issued;
    const int handed_out = caller.jobs();
    (void)caller.show(picture);
    const int here = static_cast<int>(caller.state().counters.jobs_issued - issued) -
                     (caller.jobs() - handed_out);
    EXPECT_TRUE(caller.out<AdjustmentJob>() == nullptr || caller.state().jobs.adjustment.of_all);
    windows += here;
    long_ones += caller.jobs() - handed_out;
  }
  EXPECT_GT(windows, 10);
  EXPECT_GT(long_ones, 3);
}

TEST(Jobs, AMapThatBeginsIsNotFittedAsAFreeBodyWithinTheStep) {
  Caller caller(parameters(), delayed(1), Run::kWhenDue);
  for (const Picture& picture : turning_ball()) {
    (void)caller.show(picture);
    if (caller.state().mapping.map.keyframe_count > 0) {
      break;
    }
  }
  ASSERT_GT(caller.state().mapping.map.keyframe_count, 0);
  EXPECT_EQ(caller.state().jobs.adjustment.marginal_fits, 0U);
  EXPECT_FALSE(caller.state().jobs.adjustment.as_free_body);
}

TEST(Jobs, AMapThatBeginsWithManyKeyframesIsAdjustedBesideTheSteps) {
  const Ball ball(61);
  Parameters late = parameters();
  late.start.frames_min = 16;
  Caller caller(late, delayed(1), Run::kWhenDue);
  int put_off = 0;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Matrix3d R_CT = so3_exp(Eigen::Vector3d(0.0007, 0.003, 0.0003) * i);
    (void)caller.show(ball.seen_from({.R_CT = R_CT, .p_CT = {0.0, 0.0, 6.0}}));
    put_off += caller.out<AdjustmentJob>() != nullptr &&
                       caller.state().jobs.adjustment.reason != AdjustmentReason::kMapGrown
                   ? 1
                   : 0;
  }
  EXPECT_EQ(put_off, 2) << "of the start's landmarks, and of what completes the map";
  EXPECT_EQ(caller.state().mode.now, Mode::kTracking);
  EXPECT_EQ(caller.component().counters().lost, 0U);
  EXPECT_GT(caller.state().mapping.map.keyframe_count, 12);
}

TEST(Jobs, ADueJobThatIsNotHandedInIsAMistakeOfTheCaller) {
  Caller caller(parameters(), delayed(1), Run::kAtOnce);
  std::size_t i = 0;
  while (i < turning_ball().size() && caller.out<InitialisationJob>() == nullptr) {
    (void)caller.show(turning_ball()[i++]);
  }
  ASSERT_NE(caller.out<InitialisationJob>(), nullptr);
  const StepInput without{.frame = frame_of(100 * Bench::kSecond_ns, turning_ball().back())};
  EXPECT_DEATH((void)caller.component().step(without), "");
}

TEST(Jobs, AMapGoesOnGrowingWhileItIsAdjusted_NotWhileAStartIsSought) {
  Caller caller(parameters(), delayed(8), Run::kWhenDue);
  std::int32_t keyframes = 0;
  int grown = 0;
  for (const Picture& picture : turning_ball()) {
    const bool adjusted = caller.out<AdjustmentJob>() != nullptr;
    const bool sought = caller.out<InitialisationJob>() != nullptr;
    (void)caller.show(picture);
    const Component::State& s = state_of(caller.component());
    grown += adjusted && s.mapping.map.keyframe_count > keyframes ? 1 : 0;
    if (sought && caller.out<InitialisationJob>() != nullptr) {
      EXPECT_EQ(s.mapping.map.keyframe_count, keyframes);
    }
    keyframes = s.mapping.map.keyframe_count;
  }
  EXPECT_GT(grown, 5);
  EXPECT_GT(caller.jobs(), 2);
}

TEST(Jobs, WhatGrewMeanwhileIsAdjustedNext) {
  Caller caller(parameters(), delayed(6), Run::kWhenDue);
  int waited = 0;
  for (const Picture& picture : turning_ball()) {
    const bool waiting = caller.state().mapping.growth.any;
    const Job* const before = caller.map_job_out();
    const bool due = before != nullptr && due_step(*before) == caller.component().next_step();
    (void)caller.show(picture);
    if (waiting && due && caller.state().jobs.adjustment.reason == AdjustmentReason::kMapGrown) {
      EXPECT_NE(caller.out<AdjustmentJob>(), nullptr);
      ++waited;
    }
  }
  EXPECT_GT(waited, 1);
}

TEST(Jobs, AMapThatGrowsWhileItIsAdjustedKeepsItsShape) {
  // The ball turns by 3 deg a frame: with a delay of six frames that is 18 deg from result to
  // result.
  Caller& at_once = shown(delayed(0), Run::kWhenDue);
  Caller& late = shown(delayed(6), Run::kWhenDue);
  for (Caller* caller : {&at_once, &late}) {
    const Component::State& s = state_of(caller->component());
    EXPECT_EQ(s.counters.lost, 0U);
    EXPECT_EQ(s.mode.now, Mode::kTracking);
    // All residuals of the map, in units of the features' sigma.
    EXPECT_LT(residual_scale(s.mapping.map, s.configuration.camera), 1.5);
  }
  EXPECT_GT(3 * late.state().mapping.map.keyframe_count,
            2 * at_once.state().mapping.map.keyframe_count);
}

/// As Caller, for trouble: steps until the first job, then what the test says.
class Trouble : public ::testing::Test {
 protected:
  Trouble() : bench_(with_delay()) {
    while (jobs_.empty() && next_ < turning_ball().size()) {
      jobs_ = step({}).jobs;
    }
  }
  static Parameters with_delay() {
    Parameters p = parameters();
    p.jobs = delayed(1);
    return p;
  }
  const StepOutput& step(const Jobs& finished, bool memory_short = false) {
    const std::size_t i = next_++ % turning_ball().size();
    return bench_.component->step(
        {.frame = frame_of(static_cast<std::int64_t>(next_) * Bench::kSecond_ns, turning_ball()[i]),
         .finished = finished,
         .memory_short = memory_short});
  }
  Bench bench_;
  std::size_t next_ = 0;
  /// Runs what the last step has issued, and makes the next one.
  void run_and_step() {
    for (Job* job : jobs_) {
      run_job(*job);
    }
    jobs_ = step(jobs_).jobs;
  }
  Jobs jobs_;
};

TEST_F(Trouble, AJobThatWasSkippedIsCounted_AndTheNextOneIsTried) {
  ASSERT_EQ(jobs_.size(), 1U);
  skip_job(*jobs_[0]);
  jobs_ = step(jobs_).jobs;
  EXPECT_EQ(bench_.component->counters().jobs_without_result, 1U);
  EXPECT_EQ(state_of(*bench_.component).mode.now, Mode::kAcquiring);
  for (int i = 0; i < 10; ++i) {
    run_and_step();
  }
  EXPECT_EQ(state_of(*bench_.component).mode.now, Mode::kTracking);
  EXPECT_EQ(bench_.component->counters().jobs_without_result, 1U);
}

TEST_F(Trouble, WhenMemoryIsShortLessIsAsked_ForAWhile) {
  ASSERT_EQ(jobs_.size(), 1U);
  run_job(*jobs_[0]);
  const std::size_t before = state_of(*bench_.component).features.features.size();
  jobs_ = step(jobs_, true).jobs;
  EXPECT_EQ(bench_.component->counters().steps_short_of_memory, 1U);
  if (state_of(*bench_.component).features.ready) {
    EXPECT_LT(state_of(*bench_.component).features.features.size(), before);
  }
  for (int i = 0; i < 40; ++i) {
    run_and_step();
  }
  EXPECT_EQ(bench_.component->counters().steps_short_of_memory, 30U);
  EXPECT_EQ(state_of(*bench_.component).steps_to_shed, 0U);
}

}  // namespace
}  // namespace polhode::results_test
