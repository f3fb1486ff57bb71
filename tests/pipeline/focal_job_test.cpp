// The test of the focal length: as a job, when it is asked for, and what is told when it refutes.
#include "pipeline/focal_job.hpp"

#include <gtest/gtest.h>

#include "../solve/focal_scene.hpp"
#include "job_caller.hpp"
#include "packets_of.hpp"
#include "pipeline/checkpoint.hpp"

namespace polhode::focal_job_test {
namespace {

using namespace bench;
using testing::focal_scene;

constexpr FocalReport kRefuting{.usable = true, .factor = 1.2, .relative_sigma = 0.01};
constexpr FocalReport kBearingOut{.usable = true, .factor = 1.01, .relative_sigma = 0.01};
constexpr FocalReport kUndecided{.usable = true, .factor = 1.3, .relative_sigma = 0.1};

FocalJob prepared(testing::BundleScene s) {
  FocalJob job;
  prepare_focal(s.problem(), &job);
  return job;
}

TEST(FocalJob, RefutesAWrongOne_AndBearsTheRightOneOut) {
  for (const double part : {0.85, 1.0, 1.15}) {
    FocalJob job = prepared(focal_scene(part, 5));
    run_focal(&job);
    EXPECT_EQ(refutes_focal(job.report), part != 1.0) << part;
    EXPECT_EQ(bears_focal_out(job.report), part == 1.0) << part;
  }
}

TEST(FocalJob, TakesAsManyObservationsAsItHasRoomFor_OfEveryPose) {
  testing::BundleScene s = focal_scene(0.85, 5, 3.0, 70, 200);
  ASSERT_GT(s.observations.size(), 2 * FocalJob::kObservations);
  FocalJob job = prepared(s);
  EXPECT_EQ(job.poses.size(), 24U) << "every third";
  EXPECT_EQ(job.pose_fixed[0], 1);
  EXPECT_GT(job.observations.size(), FocalJob::kObservations * 9 / 10);
  std::vector<int> of_pose(job.poses.size(), 0);
  for (const BundleObservation& o : job.observations) {
    ++of_pose[static_cast<std::size_t>(o.pose)];
  }
  EXPECT_GT(*std::min_element(of_pose.begin(), of_pose.end()), 0);
  run_focal(&job);
  EXPECT_LE(job.report.observations, FocalJob::kObservations);
  EXPECT_TRUE(refutes_focal(job.report));
}

TEST(FocalJob, DamagedInMemoryHasNoResult) {
  const auto ends_without_result = [](const auto& damage) {
    FocalJob job = prepared(focal_scene(0.85, 5));
    job.report = kRefuting;
    damage(&job);
    run_focal(&job);
    return !job.report.usable;
  };
  EXPECT_TRUE(ends_without_result([](FocalJob* job) { job->observations[3].point = 1 << 20; }));
  EXPECT_TRUE(ends_without_result([](FocalJob* job) { job->observations[3].pose = -1; }));
  EXPECT_TRUE(ends_without_result([](FocalJob* job) { job->pose_fixed.clear(); }));
}

TEST(FocalState, KeepsTheLastTestThatDecided) {
  FocalState state;
  take_focal(kUndecided, &state);
  EXPECT_FALSE(state.found.usable);
  take_focal(kRefuting, &state);
  take_focal(kUndecided, &state);
  take_focal({}, &state);
  EXPECT_TRUE(refutes_focal(state.found));
  take_focal(kBearingOut, &state);
  EXPECT_FALSE(refutes_focal(state.found));
}

/// Tests that were issued, by the number of the map's next keyframe.
std::vector<std::uint32_t> tests_of(JobOptions jobs) {
  Caller caller(parameters(), jobs, Run::kWhenDue);
  std::vector<std::uint32_t> next;
  for (const Picture& picture : turning_ball()) {
    const bool was_out = caller.out<FocalJob>() != nullptr;
    (void)caller.show(picture);
    if (!was_out && caller.out<FocalJob>() != nullptr) {
      next.push_back(caller.state().focal.next_keyframe);
    }
  }
  return next;
}

TEST(FocalTest, IsAskedForEachTimeThatThereAreTwiceAsManyKeyframes) {
  const std::vector<std::uint32_t> next = tests_of(delayed(1));
  ASSERT_GE(next.size(), 2U);
  EXPECT_GE(next[0], 6U);
  for (std::size_t i = 1; i < next.size(); ++i) {
    EXPECT_GE(next[i], 2 * next[i - 1]);
  }
}

TEST(FocalTest, IsNotAskedForWhereNoJobLeavesItsStep) {
  EXPECT_TRUE(tests_of(delayed(0)).empty());
  EXPECT_EQ(shown(delayed(0), Run::kWhenDue).state().focal.next_keyframe, 0U);
}

int events_of_doubt(const StepOutput& out) {
  int events = 0;
  for (const auto& event : packets_of<bus::EventPacket>(out)) {
    events += event.id == static_cast<std::uint16_t>(bus::EventId::kFocalLengthDoubted) ? 1 : 0;
  }
  return events;
}

// verifies: MAP-11
TEST(FocalDoubt, IsToldOnce_AndWidensWhatIsPublished) {
  Bench sure(parameters());
  Bench doubting(parameters());
  const std::vector<Picture>& pictures = turning_ball();
  constexpr std::size_t kFrames = 14;
  for (std::size_t i = 0; i < kFrames; ++i) {
    (void)sure.show(pictures[i]);
    EXPECT_EQ(events_of_doubt(doubting.show(pictures[i])), 0);
  }
  state_of(*doubting.component).focal.found = kRefuting;
  const MotionState narrow = sure.show(pictures[kFrames]).motion;
  const StepOutput& out = doubting.show(pictures[kFrames]);
  ASSERT_TRUE(narrow.pose_valid && out.motion.pose_valid);
  EXPECT_EQ(events_of_doubt(out), 1);
  const double part = part_off(kRefuting);
  const Eigen::Vector3d p_C(narrow.p_CT[0], narrow.p_CT[1], narrow.p_CT[2]);
  const double turn_rad = part * state_of(*doubting.component).mapping.map.radius_mu / p_C.norm();
  // Element 0 is the variance about x, element 20 that along z.
  EXPECT_NEAR(out.motion.cov_pose[0] - narrow.cov_pose[0], turn_rad * turn_rad, 1e-12);
  const double along = part * p_C.z();
  EXPECT_NEAR(out.motion.cov_pose[20] - narrow.cov_pose[20], along * along, 1e-9 * along * along);
  EXPECT_EQ(out.motion.q_CT, narrow.q_CT) << "the estimate is as it was";
  EXPECT_EQ(events_of_doubt(doubting.show(pictures[kFrames + 1])), 0);
}

TEST(FocalDoubt, OutlivesARestart) {
  Bench b(parameters());
  state_of(*b.component).focal.found = kRefuting;
  state_of(*b.component).focal.waits = true;
  std::vector<std::uint8_t> octets(checkpoint_octets_max());
  octets.resize(save_checkpoint(*b.component, octets));
  Bench restored(parameters());
  ASSERT_TRUE(restore_checkpoint(octets, restored.component));
  EXPECT_TRUE(refutes_focal(state_of(*restored.component).focal.found));
  EXPECT_FALSE(state_of(*restored.component).focal.waits) << "what was prepared is lost";
}

}  // namespace
}  // namespace polhode::focal_job_test
