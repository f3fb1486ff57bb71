// The test of the stated camera: as a job, when it is asked for, and what is told when it
// contradicts.
#include "pipeline/camera_job.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "../solve/camera_scene.hpp"
#include "job_caller.hpp"
#include "packets_of.hpp"
#include "pipeline/checkpoint.hpp"

namespace polhode::camera_job_test {
namespace {

using namespace bench;
using testing::camera_scene;
using testing::CameraScene;
using testing::deviating;

CameraFinding contradicting(Deviation deviation, double value, double sigma) {
  CameraFinding found;
  const auto i = static_cast<std::size_t>(deviation);
  found.contradicted[i] = 1;
  found.value[static_cast<Eigen::Index>(i)] = value;
  found.sigma[static_cast<Eigen::Index>(i)] = sigma;
  return found;
}

/// Newest first, as a map's snapshot is.
std::unique_ptr<AdjustmentSnapshot> snapshot_of(const CameraScene& s) {
  auto map = std::make_unique<AdjustmentSnapshot>();
  const std::size_t poses = s.bundle.poses.size();
  for (std::size_t k = 0; k < poses; ++k) {
    const std::size_t from = poses - 1 - k;
    (void)map->poses.push_back(s.bundle.poses[from]);
    (void)map->pose_fixed.push_back(k == 0 ? 1 : 0);
    (void)map->timestamps_ns.push_back(static_cast<std::int64_t>(from) * 1'000'000'000);
  }
  for (const Eigen::Vector3d& point : s.bundle.points_T) {
    (void)map->points_T.push_back(point);
    (void)map->point_fixed.push_back(0);
  }
  for (BundleObservation o : s.bundle.observations) {
    o.pose = static_cast<std::int32_t>(poses) - 1 - o.pose;
    (void)map->observations.push_back(o);
  }
  return map;
}

CameraJob prepared(const CameraScene& s) {
  CameraJob job;
  const auto map = snapshot_of(s);
  const MapMotions motions = motions_of(*map);
  constexpr CameraModel kCamera{.height_px = 700, .fv_px = 1000.0};
  const CameraProblem problem = camera_problem_of(motions, kCamera, map.get());
  EXPECT_EQ(problem.interval_s, 1.0);
  prepare_camera_test(problem, &job);
  return job;
}

TEST(MapMotions, AreRatesOfThePosesBeside_AndPhases) {
  const CameraScene s = camera_scene(Deviations::Zero(), 5);
  const MapMotions motions = motions_of(*snapshot_of(s));
  const std::size_t last = motions.size() - 1;
  ASSERT_EQ(motions.size(), s.motions.size());
  EXPECT_EQ(motions[0].phase, 0.5);
  EXPECT_EQ(motions[last].phase, -0.5);
  for (std::size_t k = 0; k <= last; ++k) {  // the scene's are of poses that nothing disturbed
    EXPECT_LT((motions[k].rates - s.motions[last - k].rates).norm(), 0.05) << k;
  }
}

TEST(MapMotions, AreUnknownOverALongTurn) {
  auto map = std::make_unique<AdjustmentSnapshot>();
  for (int k = 0; k < 3; ++k) {
    (void)map->poses.push_back({.R_CT = so3_exp({0.0, 0.9 * k, 0.0})});
    (void)map->timestamps_ns.push_back(-k);
  }
  const MapMotions motions = motions_of(*map);
  EXPECT_FALSE(motions[0].rates.isZero());
  EXPECT_TRUE(motions[1].rates.isZero());
}

// verifies: MAP-11
TEST(CameraJob, ContradictsAWrongOne_AndNotTheRightOne) {
  for (const double log_factor : {-0.15, 0.0, 0.15}) {
    CameraJob job = prepared(camera_scene(deviating(Deviation::kFocal, log_factor), 5));
    run_camera_test(&job);
    const CameraFinding found = find_deviations(job.fit);
    EXPECT_EQ(found.is(Deviation::kFocal), log_factor != 0.0) << log_factor;
  }
  CameraJob job = prepared(camera_scene(deviating(Deviation::kReadout, 0.1), 5));
  run_camera_test(&job);
  EXPECT_NEAR(find_deviations(job.fit).of(Deviation::kReadout), 0.1, 0.03);
}

TEST(CameraJob, TakesAsManyObservationsAsItHasRoomFor_OfEveryPose) {
  const CameraScene s =
      camera_scene(deviating(Deviation::kFocal, -0.15), 5, {.poses = 70, .points = 200});
  ASSERT_GT(s.bundle.observations.size(), 2 * CameraJob::kObservations);
  CameraJob job = prepared(s);
  EXPECT_EQ(job.poses.size(), CameraJob::kPoses);
  EXPECT_EQ(job.motions[0].phase, 0.5);
  EXPECT_LT(job.motions[CameraJob::kPoses - 1].phase, -0.45) << "over all of the time";
  EXPECT_EQ(job.pose_fixed[0], 1);
  EXPECT_GT(job.observations.size(), CameraJob::kObservations * 9 / 10);
  std::vector<int> of_pose(job.poses.size(), 0);
  for (const BundleObservation& o : job.observations) {
    ++of_pose[static_cast<std::size_t>(o.pose)];
  }
  EXPECT_GT(*std::min_element(of_pose.begin(), of_pose.end()), 0);
  run_camera_test(&job);
  EXPECT_LE(job.fit.observations, CameraJob::kObservations);
  EXPECT_TRUE(find_deviations(job.fit).is(Deviation::kFocal));
}

TEST(CameraJob, DamagedInMemoryHasNoResult) {
  const auto ends_without_result = [](const auto& damage) {
    CameraJob job = prepared(camera_scene(deviating(Deviation::kFocal, -0.15), 5));
    job.fit.usable = true;
    damage(&job);
    run_camera_test(&job);
    return !job.fit.usable;
  };
  EXPECT_TRUE(ends_without_result([](CameraJob* job) { job->observations[3].point = 1 << 20; }));
  EXPECT_TRUE(ends_without_result([](CameraJob* job) { job->observations[3].pose = -1; }));
  EXPECT_TRUE(ends_without_result([](CameraJob* job) { job->pose_fixed.clear(); }));
  EXPECT_TRUE(ends_without_result([](CameraJob* job) { job->motions.clear(); }));
}

TEST(CameraState, ATestWithoutAResultChangesNothing) {
  CameraState state;
  state.found = contradicting(Deviation::kAspect, 0.1, 0.01);
  take_camera_test({}, &state);
  EXPECT_TRUE(state.found.is(Deviation::kAspect));
}

TEST(CameraState, WhatWasDamagedIsNotTaken) {
  CameraJob job = prepared(camera_scene(deviating(Deviation::kFocal, -0.15), 5));
  run_camera_test(&job);
  for (double* number :
       {&job.fit.value[2], &job.fit.information(2, 2), &job.fit.rates.turn_rad_s}) {
    CameraFit damaged = job.fit;
    const auto offset = reinterpret_cast<char*>(number) - reinterpret_cast<char*>(&job.fit);
    *reinterpret_cast<double*>(reinterpret_cast<char*>(&damaged) + offset) = 1e200;
    CameraState state;
    take_camera_test(damaged, &state);
    EXPECT_TRUE(is_valid(state)) << offset;
  }
}

/// Tests that were issued, by the number of the map's next keyframe.
std::vector<std::uint32_t> tests_of(JobOptions jobs) {
  Caller caller(parameters(), jobs, Run::kWhenDue);
  std::vector<std::uint32_t> next;
  for (const Picture& picture : turning_ball()) {
    const bool was_out = caller.out<CameraJob>() != nullptr;
    (void)caller.show(picture);
    if (!was_out && caller.out<CameraJob>() != nullptr) {
      next.push_back(caller.state().camera.next_keyframe);
    }
  }
  return next;
}

TEST(CameraTest, IsAskedForEachTimeThatThereAreTwiceAsManyKeyframes) {
  const std::vector<std::uint32_t> next = tests_of(delayed(1));
  ASSERT_GE(next.size(), 2U);
  EXPECT_GE(next[0], 6U);
  for (std::size_t i = 1; i < next.size(); ++i) {
    EXPECT_GE(next[i], 2 * next[i - 1]);
  }
}

TEST(CameraTest, IsNotAskedForWhereNoJobLeavesItsStep) {
  EXPECT_TRUE(tests_of(delayed(0)).empty());
  EXPECT_EQ(shown(delayed(0), Run::kWhenDue).state().camera.next_keyframe, 0U);
}

int events_of(bus::EventId id, const StepOutput& out) {
  int events = 0;
  for (const auto& event : packets_of<bus::EventPacket>(out)) {
    events += event.id == static_cast<std::uint16_t>(id) ? 1 : 0;
  }
  return events;
}

int events_of_doubt(const StepOutput& out) {
  return events_of(bus::EventId::kFocalLengthDoubted, out);
}

constexpr double kLogFactor = 0.18;

// verifies: MAP-11
TEST(CameraDoubt, IsToldOnce_AndWidensWhatIsPublished) {
  Bench sure(parameters());
  Bench doubting(parameters());
  const std::vector<Picture>& pictures = turning_ball();
  constexpr std::size_t kFrames = 14;
  for (std::size_t i = 0; i < kFrames; ++i) {
    (void)sure.show(pictures[i]);
    EXPECT_EQ(events_of_doubt(doubting.show(pictures[i])), 0);
  }
  state_of(*doubting.component).camera.found = contradicting(Deviation::kFocal, kLogFactor, 0.01);
  const MotionState narrow = sure.show(pictures[kFrames]).motion;
  const StepOutput& out = doubting.show(pictures[kFrames]);
  ASSERT_TRUE(narrow.pose_valid && out.motion.pose_valid);
  EXPECT_EQ(events_of_doubt(out), 1);
  const double part = kLogFactor;
  const Eigen::Vector3d p_C(narrow.p_CT[0], narrow.p_CT[1], narrow.p_CT[2]);
  const double turn_rad = part * state_of(*doubting.component).mapping.map.radius_mu / p_C.norm();
  // Element 0 is the variance about x, element 20 that along z.
  EXPECT_NEAR(out.motion.cov_pose[0] - narrow.cov_pose[0], turn_rad * turn_rad, 1e-12);
  const double along = part * p_C.z();
  EXPECT_NEAR(out.motion.cov_pose[20] - narrow.cov_pose[20], along * along, 1e-9 * along * along);
  EXPECT_EQ(out.motion.q_CT, narrow.q_CT) << "the estimate is as it was";
  EXPECT_EQ(events_of_doubt(doubting.show(pictures[kFrames + 1])), 0);
}

// verifies: MAP-11
TEST(CameraDoubt, EachDeviationIsToldInItsUnit) {
  Bench b(parameters());
  const std::vector<Picture>& pictures = turning_ball();
  (void)b.show(pictures[0]);
  const CameraModel& stated = state_of(*b.component).configuration.camera;
  CameraFinding found = contradicting(Deviation::kPrincipalU, 0.05, 0.01);
  found.contradicted.fill(1);
  found.contradicted[0] = 0;
  state_of(*b.component).camera.found = found;
  const StepOutput& out = b.show(pictures[1]);
  EXPECT_EQ(events_of(bus::EventId::kCameraContradicted, out), 4) << "its burst";
  EXPECT_EQ(events_of(bus::EventId::kFocalLengthDoubted, out), 0);
  int of_point = 0;
  for (const auto& event : packets_of<bus::EventPacket>(out)) {
    const std::string_view text(event.text.data(), event.text_octets);
    if (text.find("principal point [px]") != std::string_view::npos) {
      ++of_point;
      EXPECT_NEAR(event.value[0], stated.cu_px + 0.05 * stated.fu_px, 1e-3);
      EXPECT_NEAR(event.value[1], stated.cv_px, 1e-3);
    }
  }
  EXPECT_EQ(of_point, 1) << "one statement of two numbers";
}

/// Worst variance of an attitude that is published as a prediction.
double predicted_variance(Bench* b, std::size_t from, std::size_t to) {
  double worst = 0.0;
  for (std::size_t i = from; i < to; ++i) {
    for (const auto& packet : packets_of<bus::PredictionPacket>(b->show(turning_ball()[i]))) {
      worst = std::max(worst, static_cast<double>(packet.cov_pose[0]));
    }
  }
  return worst;
}

TEST(CameraDoubt, WidensWhatIsPredicted) {
  Bench sure(parameters());
  Bench doubting(parameters());
  constexpr std::size_t kFrames = 14;
  for (std::size_t i = 0; i < kFrames; ++i) {
    (void)sure.show(turning_ball()[i]);
    (void)doubting.show(turning_ball()[i]);
  }
  CameraFinding found = contradicting(Deviation::kPrincipalU, 0.05, 0.01);
  found.contradicted[static_cast<std::size_t>(Deviation::kPrincipalV)] = 1;
  state_of(*doubting.component).camera.found = found;
  const double narrow = predicted_variance(&sure, kFrames, kFrames + 12);
  ASSERT_GT(narrow, 0.0);
  EXPECT_NEAR(predicted_variance(&doubting, kFrames, kFrames + 12) - narrow, 0.05 * 0.05, 1e-6);
}

TEST(CameraDoubt, OutlivesARestart) {
  Bench b(parameters());
  state_of(*b.component).camera.found = contradicting(Deviation::kFocal, kLogFactor, 0.01);
  state_of(*b.component).camera.waits = true;
  std::vector<std::uint8_t> octets(checkpoint_octets_max());
  octets.resize(save_checkpoint(*b.component, octets));
  Bench restored(parameters());
  ASSERT_TRUE(restore_checkpoint(octets, restored.component));
  EXPECT_TRUE(state_of(*restored.component).camera.found.is(Deviation::kFocal));
  EXPECT_FALSE(state_of(*restored.component).camera.waits) << "what was prepared is lost";
}

}  // namespace
}  // namespace polhode::camera_job_test
