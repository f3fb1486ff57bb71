#include "os/linux/worker.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "pipeline/jobs.hpp"

namespace polhode::platform {
namespace {

/// A contest without frames: it ends at once, undecided.
std::unique_ptr<Job> job_due_at(std::uint32_t step) {
  auto job = std::make_unique<Job>();
  job->kind = JobKind::kStart;
  job->due_step = step;
  return job;
}

class WorkerTest : public ::testing::TestWithParam<bool> {};

TEST_P(WorkerTest, HandsAJobBackToTheStepThatItNames_RunToItsEnd) {
  Worker worker({.own_thread = GetParam()});
  for (std::uint32_t i = 0; i < 20; ++i) {
    const auto job = job_due_at(i + 3);
    worker.submit(job.get());
    EXPECT_EQ(worker.due(i + 1), nullptr);
    EXPECT_EQ(worker.due(i + 2), nullptr);
    Job* finished = worker.due(i + 3);
    ASSERT_EQ(finished, job.get());
    EXPECT_TRUE(finished->done);
    EXPECT_EQ(worker.due(i + 4), nullptr) << "once";
  }
}

TEST_P(WorkerTest, NoJobIsNoWork) {
  Worker worker({.own_thread = GetParam()});
  worker.submit(nullptr);
  EXPECT_EQ(worker.due(7), nullptr);
  EXPECT_FALSE(worker.late_for(7));
  worker.finish();
}

TEST_P(WorkerTest, WaitsForALateJob) {
  Worker worker({.own_thread = GetParam(), .latency_ms_max = 30});
  for (std::uint32_t i = 0; i < 5; ++i) {
    const auto job = job_due_at(i);
    worker.submit(job.get());
    ASSERT_EQ(worker.due(i), job.get());
    EXPECT_TRUE(job->done);
    EXPECT_FALSE(worker.late_for(i));
  }
}

TEST_P(WorkerTest, EndsWithAJobStillOut) {
  const auto job = job_due_at(1);
  Worker worker({.own_thread = GetParam(), .latency_ms_max = 10});
  worker.submit(job.get());
  worker.finish();
  EXPECT_TRUE(job->done);
  EXPECT_EQ(worker.due(1), nullptr) << "it is the caller's again";
}

INSTANTIATE_TEST_SUITE_P(InlineAndBeside, WorkerTest, ::testing::Bool());

TEST(Worker, SaysWhetherItGotItsThread) {
  EXPECT_TRUE(Worker({.own_thread = true}).state().own_thread);
  EXPECT_FALSE(Worker({.own_thread = false}).state().own_thread);
  EXPECT_GE(cores_available(), 1);
}

}  // namespace
}  // namespace polhode::platform
