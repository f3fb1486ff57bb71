// A body that is touched, and moves otherwise from then on.
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "geometry/so3.hpp"
#include "motion/disturbance.hpp"
#include "motion/estimator.hpp"

namespace polhode::disturbance_test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr double kStep_rad = 0.1;
constexpr double kSigma_rad = 1e-3;
const PoseCovariance kCovariance = kSigma_rad * kSigma_rad * PoseCovariance::Identity();

Pose pose_at(double angle_rad) {
  return {.R_CT = so3_exp(angle_rad * Eigen::Vector3d(0.0, 1.0, 0.0)), .p_CT = {0.0, 0.0, 8.0}};
}

/// A body whose steady turn has been fitted, and then seen for so many poses more.
struct Bench {
  std::unique_ptr<MotionEstimate> motion = std::make_unique<MotionEstimate>();
  std::unique_ptr<Map> map = std::make_unique<Map>();
  std::int64_t now_ns = 0;
  double angle_rad = 0.0;
  bool repeated = false;  ///< the last pose shown

  explicit Bench(int poses_since_fit) {
    map->radius_mu = 1.0;
    for (int i = 0; i < 20; ++i) {
      (void)show(kStep_rad);
    }
    auto snapshot = std::make_unique<MotionSnapshot>();
    auto work = std::make_unique<MotionWorkspace>();
    prepare_fit(*map, {}, {}, motion.get(), snapshot.get());
    take_fit(fit_rigid_model(*snapshot, *work), now_ns, 20, {}, motion.get());
    EXPECT_TRUE(motion->model.accepted());
    for (int i = 0; i < poses_since_fit; ++i) {
      EXPECT_FALSE(show(kStep_rad));
    }
  }

  /// The next pose, so far on and beside that by an error of its own. @return begun anew?
  bool show(double step_rad, double error_rad = 0.0) {
    return judged(step_rad, error_rad).begun_anew;
  }

  PoseJudgement judged(double step_rad, double error_rad = 0.0) {
    now_ns += kSecond_ns;
    angle_rad += step_rad;
    const Pose pose = pose_at(angle_rad + error_rad);
    repeated = repeats_last({.timestamp_ns = now_ns, .pose = pose, .covariance = kCovariance},
                            motion.get());
    if (repeated) {
      return {};
    }
    const PoseJudgement judgement = check_pose(now_ns, pose, kCovariance, {}, motion.get());
    (void)remember_pose(now_ns, pose, kCovariance, {}, motion.get());
    return judgement;
  }

  /// How far from where the body is if it turns on as it did.
  [[nodiscard]] double off_rad(const Pose& pose) const {
    return rotation_angle_rad(pose.R_CT, pose_at(angle_rad + kStep_rad).R_CT);
  }

  [[nodiscard]] Result<RateEstimate> rates() const { return rates_now(*motion, {}, {}); }
};

// verifies: MOT-09
TEST(Disturbance, IsToldByTwoPoses_AndWhatWasBeforeIsForgotten) {
  Bench b(16);
  const std::int64_t before_ns = b.now_ns;
  EXPECT_FALSE(b.show(1.33 * kStep_rad)) << "it may be a wrong pose";
  EXPECT_FALSE(b.rates().ok()) << "neither rate is known";
  EXPECT_FALSE(moves_alike_since(0, *b.motion));
  EXPECT_TRUE(b.show(1.33 * kStep_rad));
  EXPECT_FALSE(b.motion->model.accepted());
  EXPECT_EQ(b.motion->recent[0].timestamp_ns, before_ns + kSecond_ns);
  EXPECT_EQ(b.motion->past[0].timestamp_ns, before_ns + kSecond_ns);
  EXPECT_FALSE(moves_alike_since(before_ns, *b.motion));
  EXPECT_TRUE(moves_alike_since(before_ns + kSecond_ns, *b.motion));
  const Result<RateEstimate> rates = b.rates();
  ASSERT_TRUE(rates.ok());
  EXPECT_NEAR(rates.value().w_T_rad_s.y(), 1.33 * kStep_rad, 3.0 * kSigma_rad);
}

TEST(Disturbance, IsToldWhereTheBodyTurnsBack) {
  Bench b(16);
  EXPECT_FALSE(b.show(-kStep_rad));
  EXPECT_TRUE(b.show(-kStep_rad));
  ASSERT_TRUE(b.rates().ok());
  EXPECT_NEAR(b.rates().value().w_T_rad_s.y(), -kStep_rad, 3.0 * kSigma_rad);
}

TEST(Disturbance, IsNotOneWrongPose) {
  Bench b(16);
  EXPECT_FALSE(b.show(kStep_rad, 0.3));
  const std::int64_t wrong_ns = b.now_ns;
  const PoseJudgement next = b.judged(kStep_rad);
  EXPECT_FALSE(next.begun_anew) << "judged from the last pose that was right";
  EXPECT_EQ(next.withdrawn_ns, wrong_ns);
  EXPECT_FALSE(b.judged(kStep_rad).withdrawn_ns) << "once";
  EXPECT_EQ(b.motion->departures, 0U);
  EXPECT_TRUE(b.motion->model.accepted());
  ASSERT_TRUE(b.rates().ok());
  EXPECT_NEAR(b.rates().value().w_T_rad_s.y(), kStep_rad, kSigma_rad);
}

TEST(Disturbance, InDoubt_TheMotionIsExpectedToLeadOn_AndAfterItTheDepartedPose) {
  Bench b(16);
  EXPECT_FALSE(expected_from_departed(*b.motion, {}, {}, b.now_ns + kSecond_ns));
  constexpr double kError_rad = 0.3;
  (void)b.show(kStep_rad, kError_rad);
  const std::int64_t next_ns = b.now_ns + kSecond_ns;
  const auto by_motion = predict_or_hold(*b.motion, {}, {}, next_ns, b.motion->R_IC);
  ASSERT_TRUE(by_motion);
  EXPECT_LT(b.off_rad(by_motion->pose), 5.0 * kSigma_rad);
  EXPECT_NEAR(
      expected_at(*by_motion, next_ns, *b.motion).step_rad, 2.0 * kStep_rad, 5.0 * kSigma_rad);
  const auto from_departed = expected_from_departed(*b.motion, {}, {}, next_ns);
  ASSERT_TRUE(from_departed);
  EXPECT_NEAR(b.off_rad(from_departed->prediction.pose), kError_rad, 5.0 * kSigma_rad);
  EXPECT_NEAR(from_departed->step_rad, kStep_rad, 5.0 * kSigma_rad);
}

TEST(Disturbance, IsNoPictureThatComesTwiceOrThreeTimes) {
  Bench b(16);
  double behind_rad = 0.0;
  for (int repeat = 0; repeat < 3; ++repeat) {
    behind_rad -= kStep_rad;  // the clock goes on, the picture stays
    (void)b.judged(kStep_rad, behind_rad);
    EXPECT_TRUE(b.repeated) << repeat;
    EXPECT_EQ(b.motion->departures, 0U) << repeat;
    EXPECT_FALSE(b.rates().ok()) << "the body may have stopped";
  }
  EXPECT_FALSE(b.show(kStep_rad));
  EXPECT_EQ(b.motion->departures, 0U);
  EXPECT_TRUE(b.motion->model.accepted());
  ASSERT_TRUE(b.rates().ok());
  EXPECT_NEAR(b.rates().value().w_T_rad_s.y(), kStep_rad, kSigma_rad);
}

TEST(Disturbance, IsNoPictureThatComesTwice_WhileTheServicerTurns) {
  Bench b(16);
  constexpr double kTurn_rad = 0.03;
  for (int repeat = 1; repeat <= 2; ++repeat) {
    const Eigen::Matrix3d R_IC = so3_exp(kTurn_rad * repeat * Eigen::Vector3d::UnitZ());
    b.motion->R_IC = R_IC;
    (void)b.show(0.0);
    EXPECT_TRUE(b.repeated) << repeat;
  }
}

TEST(Disturbance, IsNoPictureThatComesTwice_WhereTheMapHasMovedBetween) {
  Bench b(16);
  const Pose moved = pose_at(b.angle_rad + 0.05);
  move_seen(moved, b.motion.get());
  EXPECT_TRUE(repeats_last(
      {.timestamp_ns = b.now_ns + kSecond_ns, .pose = moved, .covariance = kCovariance},
      b.motion.get()));
}

TEST(Disturbance, ARepeatIsToldWhereAStepIs) {
  for (const auto& [step_sigmas, told] : {std::pair(15.0, true), std::pair(12.0, false)}) {
    Bench b(16);
    (void)b.show(step_sigmas * kSigma_rad);
    EXPECT_FALSE(b.repeated) << step_sigmas;
    (void)b.show(0.0);
    EXPECT_EQ(b.repeated, told) << step_sigmas;
  }
}

TEST(Disturbance, AStepAfterManyLostPicturesIsNoRepeat) {
  Bench b(16);
  b.now_ns += 29 * kSecond_ns;
  (void)b.show(30.0 * kStep_rad);
  (void)b.show(kStep_rad);
  EXPECT_FALSE(b.repeated) << "a thirtieth of the last step, in a thirtieth of its time";
}

TEST(Disturbance, OverAGapOfAnyNumberOfTurns_AStepIsHalfATurn) {
  Bench b(16);
  const std::int64_t later_ns = b.now_ns + 63 * kSecond_ns;  // about a whole turn
  const auto predicted = predict_or_hold(*b.motion, {}, {}, later_ns, b.motion->R_IC);
  ASSERT_TRUE(predicted);
  EXPECT_NEAR(expected_at(*predicted, later_ns, *b.motion).step_rad, 3.1416, 1e-4);
}

TEST(Disturbance, IsNoPictureThatComesTwice_BeforeThereIsAModel) {
  Bench b(0);
  refute_model(b.motion.get());
  (void)b.show(kStep_rad);
  EXPECT_FALSE(b.repeated);
  (void)b.show(0.0);
  EXPECT_TRUE(b.repeated);
  (void)b.show(kStep_rad);
  EXPECT_FALSE(b.repeated);
}

TEST(Disturbance, IsABodyThatHasStopped_AtTheSeventhPicture) {
  Bench b(16);
  for (int picture = 1; picture < 7; ++picture) {
    EXPECT_FALSE(b.show(0.0)) << picture;
  }
  EXPECT_TRUE(b.show(0.0));
}

TEST(Disturbance, OfAMotionThatLedNowhereYet_IsTheModelsFault) {
  Bench b(2);
  EXPECT_FALSE(b.show(1.33 * kStep_rad));
  EXPECT_FALSE(b.show(1.33 * kStep_rad));
  EXPECT_FALSE(b.motion->model.accepted());
  EXPECT_EQ(b.motion->recent.size(), 24U) << "the poses stay";
  EXPECT_TRUE(moves_alike_since(0, *b.motion));
}

TEST(Disturbance, IsNoLongerInDoubt_WhereTheModelGoes) {
  Bench b(16);
  (void)b.show(1.33 * kStep_rad);
  RigidModel refused;
  refused.status = ModelStatus::kResidualsTooLarge;
  take_fit(refused, b.now_ns, 1, {}, b.motion.get());
  EXPECT_TRUE(b.rates().ok()) << "local fits give one";
  EXPECT_TRUE(moves_alike_since(0, *b.motion));
}

TEST(Disturbance, IsNotToldOverAGap) {
  Bench b(16);
  (void)b.show(1.33 * kStep_rad);
  b.now_ns += 60 * kSecond_ns;  // it may have turned by any number of turns
  EXPECT_FALSE(b.show(1.0));
  EXPECT_EQ(b.motion->departures, 0U);
  EXPECT_EQ(b.motion->recent.size(), 38U) << "nothing was refuted";
}

TEST(Disturbance, IsForgottenWithTheTarget) {
  Bench b(16);
  (void)b.show(1.33 * kStep_rad);
  (void)b.show(1.33 * kStep_rad);
  reset_poses(b.motion.get());
  EXPECT_TRUE(moves_alike_since(INT64_MIN, *b.motion));
}

TEST(Disturbance, InTheNewestPosesIsNotFittedOver) {
  Bench b(0);
  auto snapshot = std::make_unique<MotionSnapshot>();
  auto work = std::make_unique<MotionWorkspace>();
  prepare_fit(*b.map, {}, {}, b.motion.get(), snapshot.get());
  PoseHistory& poses = snapshot->poses;
  poses[poses.size() - 1].pose = pose_at(b.angle_rad + 0.2);
  EXPECT_TRUE(fit_rigid_model(*snapshot, *work).accepted()) << "one may be wrong";
  poses[poses.size() - 2].pose = pose_at(b.angle_rad - kStep_rad + 0.1);
  EXPECT_EQ(fit_rigid_model(*snapshot, *work).status, ModelStatus::kResidualsTooLarge);
}

}  // namespace
}  // namespace polhode::disturbance_test
