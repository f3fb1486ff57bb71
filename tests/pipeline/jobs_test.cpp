#include "pipeline/jobs.hpp"

#include <gtest/gtest.h>

#include <utility>

#include "bench.hpp"
#include "geometry/so3.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

using namespace bench;

/// When the caller gets round to running a job: the packets must not show it.
enum class Run : std::uint8_t { kAtOnce, kWhenDue };

/// The long form of what a caller does with jobs.
class Caller {
 public:
  Caller(Parameters p, int delay_frames, Run run) : run_(run), bench_(with_delay(p, delay_frames)) {}

  const StepOutput& show(const Picture& picture) {
    Job* finished = nullptr;
    if (out_ != nullptr && due_step(*out_) == step_) {
      if (run_ == Run::kWhenDue) {
        run_job(*out_);
      }
      finished = std::exchange(out_, nullptr);
    }
    const StepOutput& out = bench_.component->step(
        {.frame = frame_of(static_cast<std::int64_t>(++step_) * Bench::kSecond_ns, picture),
         .finished = finished});
    if (out.job != nullptr) {
      EXPECT_EQ(out_, nullptr) << "two jobs at a time";
      out_ = out.job;
      ++jobs_;
      if (run_ == Run::kAtOnce) {
        run_job(*out_);
      }
    }
    packets_.insert(packets_.end(), out.packets.begin(), out.packets.end());
    return out;
  }

  [[nodiscard]] int jobs() const { return jobs_; }
  [[nodiscard]] const Job* out() const { return out_; }
  [[nodiscard]] Component& component() { return *bench_.component; }
  [[nodiscard]] const std::vector<std::uint8_t>& packets() const { return packets_; }

 private:
  static Parameters with_delay(Parameters p, int delay_frames) {
    p.jobs.delay_frames = delay_frames;
    return p;
  }
  Run run_;
  Bench bench_;
  std::uint32_t step_ = 0;
  int jobs_ = 0;
  Job* out_ = nullptr;
  std::vector<std::uint8_t> packets_;
};

/// A ball that turns by 3 deg a frame.
const std::vector<Picture>& turning_ball() {
  static const std::vector<Picture> pictures = [] {
    const Ball ball(61);
    std::vector<Picture> made;
    for (int i = 0; i < 24; ++i) {
      const Eigen::Matrix3d R_CT = so3_exp(Eigen::Vector3d(0.012, 0.052, 0.005) * i);
      made.push_back(ball.seen_from({.R_CT = R_CT, .p_CT = {0.0, 0.0, 6.0}}));
    }
    return made;
  }();
  return pictures;
}

Caller shown(int delay_frames, Run run) {
  Caller caller(parameters(), delay_frames, run);
  for (const Picture& picture : turning_ball()) {
    (void)caller.show(picture);
  }
  return caller;
}

TEST(Jobs, WithoutDelay_AreDoneWithinTheStep) {
  Caller caller = shown(0, Run::kWhenDue);
  EXPECT_EQ(caller.jobs(), 0);
  EXPECT_GT(caller.component().counters().jobs_issued, 3U);
  EXPECT_EQ(caller.component().state().mode, Mode::kTracking);
}

class JobsWithDelay : public ::testing::TestWithParam<int> {};

TEST_P(JobsWithDelay, PacketsDoNotShowWhenAJobWasRun) {
  Caller early = shown(GetParam(), Run::kAtOnce);
  Caller late = shown(GetParam(), Run::kWhenDue);
  EXPECT_GT(early.jobs(), 3);
  EXPECT_EQ(early.jobs(), late.jobs());
  EXPECT_EQ(early.packets(), late.packets());
}

TEST_P(JobsWithDelay, TheBodyIsAcquiredAndFollowed) {
  Caller caller = shown(GetParam(), Run::kWhenDue);
  EXPECT_EQ(caller.component().state().mode, Mode::kTracking);
  EXPECT_EQ(caller.component().counters().lost, 0U);
  EXPECT_GT(caller.component().state().map.keyframe_count, 3);
}

TEST_P(JobsWithDelay, AJobNamesTheStepThatTakesItsResult) {
  Caller caller(parameters(), GetParam(), Run::kAtOnce);
  std::uint32_t step = 0;
  for (const Picture& picture : turning_ball()) {
    const StepOutput& out = caller.show(picture);
    if (out.job != nullptr) {
      EXPECT_EQ(due_step(*out.job), step + static_cast<std::uint32_t>(GetParam()));
    }
    ++step;
  }
}

TEST_P(JobsWithDelay, TheEndOfARunTakesInWhatIsStillOut) {
  Caller caller(parameters(), GetParam(), Run::kAtOnce);
  for (const Picture& picture : turning_ball()) {
    if (caller.jobs() > 2 && caller.out() != nullptr) {
      break;
    }
    (void)caller.show(picture);
  }
  ASSERT_NE(caller.out(), nullptr);
  close_jobs(&caller.component().state());
  EXPECT_TRUE(job_slot_free(caller.component().state()));
}

INSTANTIATE_TEST_SUITE_P(Delays, JobsWithDelay, ::testing::Values(1, 3));

TEST(Jobs, ADueJobThatIsNotHandedInIsAMistakeOfTheCaller) {
  Caller caller(parameters(), 1, Run::kAtOnce);
  std::size_t i = 0;
  while (i < turning_ball().size() && caller.out() == nullptr) {
    (void)caller.show(turning_ball()[i++]);
  }
  ASSERT_NE(caller.out(), nullptr);
  const StepInput without{
      .frame = frame_of(100 * Bench::kSecond_ns, turning_ball().back())};
  EXPECT_DEATH((void)caller.component().step(without), "");
}

TEST(Jobs, AMapThatIsBeingAdjustedDoesNotGrow) {
  Caller caller(parameters(), 8, Run::kWhenDue);
  std::int32_t keyframes = 0;
  std::uint32_t due = 0;  // of the job that was out; 0: none
  int compared = 0;
  for (const Picture& picture : turning_ball()) {
    (void)caller.show(picture);
    const std::int32_t now = caller.component().state().map.keyframe_count;
    const std::uint32_t due_now = caller.out() == nullptr ? 0 : due_step(*caller.out());
    if (due_now != 0 && due_now == due) {
      EXPECT_EQ(now, keyframes);
      ++compared;
    }
    due = due_now;
    keyframes = now;
  }
  EXPECT_GT(compared, 5);
  EXPECT_GT(caller.jobs(), 1);
}

/// As Caller, for trouble: steps until the first job, then what the test says.
class Trouble : public ::testing::Test {
 protected:
  Trouble() : bench_(with_delay()) {
    while (job_ == nullptr && next_ < turning_ball().size()) {
      job_ = step(nullptr).job;
    }
  }
  static Parameters with_delay() {
    Parameters p = parameters();
    p.jobs.delay_frames = 1;
    return p;
  }
  const StepOutput& step(Job* finished, bool memory_short = false) {
    const std::size_t i = next_++ % turning_ball().size();
    return bench_.component->step(
        {.frame = frame_of(static_cast<std::int64_t>(next_) * Bench::kSecond_ns, turning_ball()[i]),
         .finished = finished,
         .memory_short = memory_short});
  }
  Bench bench_;
  std::size_t next_ = 0;
  Job* job_ = nullptr;
};

TEST_F(Trouble, AJobThatWasSkippedIsCounted_AndTheNextOneIsTried) {
  ASSERT_NE(job_, nullptr);
  skip_job(*job_);
  Job* next = step(job_).job;
  EXPECT_EQ(bench_.component->counters().jobs_without_result, 1U);
  EXPECT_EQ(bench_.component->state().mode, Mode::kAcquiring);
  for (int i = 0; i < 10; ++i) {
    if (next != nullptr) {
      run_job(*next);
    }
    next = step(next).job;
  }
  EXPECT_EQ(bench_.component->state().mode, Mode::kTracking);
  EXPECT_EQ(bench_.component->counters().jobs_without_result, 1U);
}

TEST_F(Trouble, WhenMemoryIsShortLessIsAsked_ForAWhile) {
  ASSERT_NE(job_, nullptr);
  run_job(*job_);
  const std::size_t before = bench_.component->state().features.size();
  Job* next = step(job_, true).job;
  EXPECT_EQ(bench_.component->counters().steps_short_of_memory, 1U);
  if (bench_.component->state().features_ready) {
    EXPECT_LT(bench_.component->state().features.size(), before);
  }
  for (int i = 0; i < 40; ++i) {
    if (next != nullptr) {
      run_job(*next);
    }
    next = step(next).job;
  }
  EXPECT_EQ(bench_.component->counters().steps_short_of_memory, 30U);
  EXPECT_EQ(bench_.component->state().steps_to_shed, 0U);
}

}  // namespace
}  // namespace polhode
