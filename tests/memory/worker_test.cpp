#include "os/linux/worker.hpp"

#include <gtest/gtest.h>
#include <sched.h>

#include <array>
#include <memory>

#include "os/linux/priority.hpp"
#include "pipeline/job.hpp"

namespace polhode::platform::worker_test {
namespace {

/// A hypothesis selection without frames: it ends at once, undecided.
std::unique_ptr<Job> job_due_at(std::uint32_t step) {
  static const auto work = std::make_unique<InitialisationJob>();
  return std::make_unique<Job>(Job{.work = work.get(), .due_step = step});
}

Jobs one(Job* job) {
  Jobs jobs;
  (void)jobs.push_back(job);
  return jobs;
}

class WorkerTest : public ::testing::TestWithParam<bool> {};

TEST_P(WorkerTest, HandsAJobBackToTheStepThatItNames_RunToItsEnd) {
  Worker worker({.own_thread = GetParam()});
  for (std::uint32_t i = 0; i < 20; ++i) {
    const auto job = job_due_at(i + 3);
    worker.submit(one(job.get()));
    EXPECT_TRUE(worker.due(i + 1).empty());
    EXPECT_TRUE(worker.due(i + 2).empty());
    const Jobs finished = worker.due(i + 3);
    ASSERT_EQ(finished.size(), 1U);
    EXPECT_EQ(finished[0], job.get());
    EXPECT_TRUE(finished[0]->done);
    EXPECT_EQ(worker.last_durations().size(), 1U);
    EXPECT_TRUE(worker.due(i + 4).empty()) << "once";
  }
}

TEST_P(WorkerTest, NoJobIsNoWork) {
  Worker worker({.own_thread = GetParam()});
  worker.submit({});
  EXPECT_TRUE(worker.due(7).empty());
  EXPECT_FALSE(worker.late_for(7));
  worker.finish();
}

TEST_P(WorkerTest, WaitsForALateJob) {
  Worker worker({.own_thread = GetParam(), .latency_ms_max = 30});
  for (std::uint32_t i = 0; i < 5; ++i) {
    const auto job = job_due_at(i);
    worker.submit(one(job.get()));
    ASSERT_EQ(worker.due(i).size(), 1U);
    EXPECT_TRUE(job->done);
    EXPECT_FALSE(worker.late_for(i));
  }
}

TEST_P(WorkerTest, EndsWithAJobStillOut) {
  const auto job = job_due_at(1);
  Worker worker({.own_thread = GetParam(), .latency_ms_max = 10});
  worker.submit(one(job.get()));
  worker.finish();
  EXPECT_TRUE(job->done);
  EXPECT_TRUE(worker.due(1).empty()) << "it is the caller's again";
}

TEST_P(WorkerTest, TwoAreOutAtATime_EachReturnsToItsOwnStep) {
  Worker worker({.own_thread = GetParam(), .latency_ms_max = 10});
  for (std::uint32_t i = 0; i < 5; ++i) {
    const auto map = job_due_at(10 * i + 5);
    const auto fit = job_due_at(10 * i + 3);
    worker.submit(one(map.get()));
    worker.submit(one(fit.get()));
    EXPECT_TRUE(worker.due(10 * i + 2).empty());
    const Jobs first = worker.due(10 * i + 3);
    ASSERT_EQ(first.size(), 1U);
    EXPECT_EQ(first[0], fit.get());
    EXPECT_TRUE(fit->done);
    const Jobs second = worker.due(10 * i + 5);
    ASSERT_EQ(second.size(), 1U);
    EXPECT_EQ(second[0], map.get());
    EXPECT_TRUE(map->done);
  }
}

TEST_P(WorkerTest, TwoThatNameTheSameStepComeBackInTheOrderOfTheirIssue) {
  Worker worker({.own_thread = GetParam(), .latency_ms_max = 10});
  for (std::uint32_t i = 0; i < 5; ++i) {
    const std::array<std::unique_ptr<Job>, 2> jobs{job_due_at(i), job_due_at(i)};
    Jobs both = one(jobs[0].get());
    (void)both.push_back(jobs[1].get());
    worker.submit(both);
    const Jobs finished = worker.due(i);
    ASSERT_EQ(finished.size(), 2U);
    EXPECT_EQ(finished[0], jobs[0].get());
    EXPECT_EQ(finished[1], jobs[1].get());
    EXPECT_EQ(worker.last_durations().size(), 2U);
  }
}

INSTANTIATE_TEST_SUITE_P(InlineAndBeside, WorkerTest, ::testing::Bool());

TEST(Worker, SaysWhetherItGotItsThread) {
  EXPECT_TRUE(Worker({.own_thread = true}).state().own_thread);
  EXPECT_FALSE(Worker({.own_thread = false}).state().own_thread);
  EXPECT_GE(cores_available(), 1);
}

TEST(Worker, TakesItsPriorityWhereItIsGranted) {
  EXPECT_FALSE(Worker({.own_thread = true}).state().real_time);
  const bool granted = take_priority(2).empty();
  const sched_param ordinary{};
  ASSERT_EQ(::sched_setscheduler(0, SCHED_OTHER, &ordinary), 0);
  EXPECT_EQ(Worker({.own_thread = true, .priority = 2}).state().real_time, granted);
}

}  // namespace
}  // namespace polhode::platform::worker_test
