// The fit of the dynamics as a job: what happens to poses, maps, targets and axes while it is out.
#include <gtest/gtest.h>

#include "../bus/command_packets.hpp"
#include "job_caller.hpp"
#include "pipeline/checkpoint.hpp"
#include "pipeline/observer.hpp"
#include "pipeline/results.hpp"

namespace polhode::fit_job_test {
namespace {

using namespace bench;

/// Shows pictures until a fit is out or, without delay, there has been one.
std::size_t show_until_fit(Caller& caller) {
  std::size_t i = 0;
  while (i < turning_ball().size() && caller.out<FitJob>() == nullptr &&
         caller.state().jobs.fit_work.model.poses == 0) {
    (void)caller.show(turning_ball()[i++]);
  }
  return i;
}

class FitJobs : public ::testing::TestWithParam<int> {};
/// With a delay: a fit is out for some frames.
class FitJobsOut : public ::testing::TestWithParam<int> {};

// verifies: CMP-02
TEST_P(FitJobs, PacketsDoNotShowWhenAFitWasRun) {
  Caller& early = shown(delayed(GetParam()), Run::kAtOnce);
  EXPECT_EQ(early.packets(), shown(delayed(GetParam()), Run::kWhenDue).packets());
  EXPECT_EQ(early.packets(), shown(delayed(GetParam()), Run::kAtRandom).packets());
  EXPECT_GT(early.fits(), GetParam() > 0 ? 1 : -1);
}

TEST_P(FitJobs, TheMotionIsFoundWhateverTheDelay) {
  Caller& caller = shown(delayed(GetParam()), Run::kWhenDue);
  const MotionEstimate& m = caller.state().motion;
  EXPECT_TRUE(m.model.accepted());
  EXPECT_LT(m.poses_since_fit, m.past.size());
}

TEST_P(FitJobs, PosesFoundMeanwhileAreKept) {
  Caller caller(parameters(), delayed(GetParam()), Run::kWhenDue);
  std::size_t poses = 0;
  for (const Picture& picture : turning_ball()) {
    const bool found = caller.show(picture).motion.pose_valid;
    const std::size_t now = caller.state().motion.recent.size();
    if (found && poses > 0) {
      EXPECT_GE(now, poses + 1);
    }
    poses = now;
  }
  EXPECT_EQ(caller.state().motion.past.size(), poses) << "too few to be thinned";
}

TEST_P(FitJobsOut, AFitOfAForgottenTargetIsNotTaken) {
  Caller caller(parameters(), delayed(GetParam()), Run::kWhenDue);
  std::size_t i = show_until_fit(caller);
  ASSERT_NE(caller.out<FitJob>(), nullptr);
  const std::vector<std::uint8_t> reset = bus::command(bus::CommandCode::kResetMap);
  const std::span<const std::uint8_t> command(reset);
  (void)caller.show(turning_ball()[i++], {&command, 1});
  while (caller.out<FitJob>() != nullptr && i < turning_ball().size()) {
    (void)caller.show(turning_ball()[i++]);
    EXPECT_FALSE(caller.state().motion.model.accepted());
  }
  EXPECT_EQ(caller.state().motion.model.poses, 0U);
}

TEST_P(FitJobsOut, AFitInOldAxesIsNotTaken) {
  Caller caller(parameters(), delayed(GetParam()), Run::kWhenDue);
  (void)show_until_fit(caller);
  ASSERT_NE(caller.out<FitJob>(), nullptr);
  set_observer({.frame = {}, .q_IC = std::array<double, 4>{0.0, 1.0, 0.0, 0.0}},
               &state_of(caller.component()));
  close_jobs(&state_of(caller.component()));
  EXPECT_FALSE(caller.state().motion.model.accepted()) << "C stood in for I when it was asked for";
}

TEST(FitJob, PosesSinceItWasAskedForJudgeIt) {
  Caller caller(parameters(), delayed(4), Run::kAtOnce);
  MotionEstimate& m = state_of(caller.component()).motion;
  const JobQueue& jobs = state_of(caller.component()).jobs;
  // A fit beside an accepted model that has been out for three poses, and that no joint fit has
  // overtaken.
  const auto waits = [&] {
    return m.model.accepted() && caller.out<FitJob>() != nullptr && !jobs.fit.unwanted &&
           m.recent.size() > 3 &&
           jobs.fit_work.snapshot.poses.back().timestamp_ns <
               m.recent[m.recent.size() - 3].timestamp_ns;
  };
  for (std::size_t i = 0; i < turning_ball().size() && !waits(); ++i) {
    (void)caller.show(turning_ball()[i]);
  }
  ASSERT_TRUE(waits());
  // The target stands elsewhere since then.
  for (std::size_t n = m.recent.size() - 3; n < m.recent.size(); ++n) {
    m.recent[n].pose.R_CT = so3_exp({0.0, 0.0, 0.7}) * m.recent[n].pose.R_CT;
  }
  // An adjustment that came back now would put them where its keyframes are.
  state_of(caller.component()).jobs.map.unwanted = true;
  close_jobs(&state_of(caller.component()));
  EXPECT_EQ(m.model.status, ModelStatus::kResidualsTooLarge);
  EXPECT_GE(m.disagreements, 3U);
}

TEST_P(FitJobsOut, AfterACheckpointAFitThatWasOutIsAskedForAgain) {
  Caller caller(parameters(), delayed(GetParam()), Run::kWhenDue);
  const std::size_t i = show_until_fit(caller);
  ASSERT_NE(caller.out<FitJob>(), nullptr);
  std::vector<std::uint8_t> octets(checkpoint_octets_max());
  octets.resize(save_checkpoint(caller.component(), octets));
  Caller restored(parameters(), delayed(GetParam()), Run::kWhenDue);
  ASSERT_TRUE(restore_checkpoint(octets, &restored.component()));
  ASSERT_EQ(restored.out<FitJob>(), nullptr);
  for (std::size_t n = i - 1; n + 1 < turning_ball().size() && restored.fits() == 0; ++n) {
    (void)restored.show(turning_ball()[n]);
  }
  EXPECT_EQ(restored.fits(), 1);
}

TEST_P(FitJobs, AFitWithoutMemoryLeavesTheModelAsItWas) {
  Caller caller(parameters(), delayed(GetParam()), Run::kWhenDue);
  (void)show_until_fit(caller);
  Component::State& s = state_of(caller.component());
  close_jobs(&s);
  const std::uint32_t before = s.counters.jobs_without_result;
  const RigidModel model = s.motion.model;
  const std::uint32_t poses_since_fit = s.motion.poses_since_fit;
  s.jobs.fit.work = &s.jobs.fit_work;
  skip_job(s.jobs.fit);
  close_jobs(&s);
  EXPECT_EQ(s.counters.jobs_without_result, before + 1);
  EXPECT_EQ(s.motion.model.poses, model.poses);
  EXPECT_EQ(s.motion.model.reference_ns, model.reference_ns);
  EXPECT_EQ(s.motion.poses_since_fit, poses_since_fit);
}

INSTANTIATE_TEST_SUITE_P(Delays, FitJobs, ::testing::Values(0, 1, 4));
INSTANTIATE_TEST_SUITE_P(Delays, FitJobsOut, ::testing::Values(1, 4));

TEST(JobsAndCommands, ResetCountersDoNotMakeTheCallerMissAJob) {
  Caller caller(parameters(), delayed(4), Run::kWhenDue);
  std::size_t i = 0;
  while (i < turning_ball().size() && caller.map_job_out() == nullptr) {
    (void)caller.show(turning_ball()[i++]);
  }
  ASSERT_NE(caller.map_job_out(), nullptr);
  const std::vector<std::uint8_t> reset = bus::command(bus::CommandCode::kResetCounters);
  const std::span<const std::uint8_t> command(reset);
  (void)caller.show(turning_ball()[i++], {&command, 1});
  EXPECT_EQ(caller.component().counters().frames_in, 1U);
  EXPECT_EQ(caller.component().next_step(), i);
  while (i < turning_ball().size()) {
    (void)caller.show(turning_ball()[i++]);
  }
  EXPECT_EQ(caller.state().mode.now, Mode::kTracking);
}

}  // namespace
}  // namespace polhode::fit_job_test
