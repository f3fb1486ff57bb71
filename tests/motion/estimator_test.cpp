#include "motion/estimator.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "geometry/so3.hpp"

namespace polhode::estimator_test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr double kStep_rad = 0.1;
const PoseCovariance kCovariance = 1e-8 * PoseCovariance::Identity();

Pose pose_at(int second, double z = 8.0) {
  return {.R_CT = so3_exp(kStep_rad * second * Eigen::Vector3d::UnitY()), .p_CT = {0.0, 0.0, z}};
}

/// A body that has turned steadily for so many seconds.
std::unique_ptr<MotionEstimate> turning(int seconds, const MotionOptions& options = {}) {
  auto motion = std::make_unique<MotionEstimate>();
  for (int second = 0; second < seconds; ++second) {
    (void)remember_pose(second * kSecond_ns, pose_at(second), kCovariance, options, motion.get());
  }
  return motion;
}

TEST(MotionEstimate, PredictsNothing_WithoutAPose) {
  const MotionEstimate motion;
  EXPECT_FALSE(predict_or_hold(motion, {}, {}, kSecond_ns, Eigen::Matrix3d::Identity()));
}

TEST(MotionEstimate, HoldsTheOnlyPose) {
  const auto motion = turning(1);
  const auto predicted =
      predict_or_hold(*motion, {}, {}, 3 * kSecond_ns, Eigen::Matrix3d::Identity());
  ASSERT_TRUE(predicted);
  EXPECT_EQ(predicted->pose.R_CT, pose_at(0).R_CT);
}

TEST(MotionEstimate, TurnsOn) {
  const auto motion = turning(6);
  const auto predicted =
      predict_or_hold(*motion, {}, {}, 6 * kSecond_ns, Eigen::Matrix3d::Identity());
  ASSERT_TRUE(predicted);
  EXPECT_LT(rotation_angle_rad(predicted->pose.R_CT, pose_at(6).R_CT), 1e-6);
}

TEST(MotionEstimate, IsNeverPredictedThroughTheCamera) {
  auto motion = std::make_unique<MotionEstimate>();
  for (int second = 0; second < 6; ++second) {
    (void)remember_pose(
        second * kSecond_ns, pose_at(second, 6.5 - second), kCovariance, {}, motion.get());
  }
  const auto predicted =
      predict_or_hold(*motion, {}, {}, 8 * kSecond_ns, Eigen::Matrix3d::Identity());
  ASSERT_TRUE(predicted);
  EXPECT_EQ(predicted->pose.p_CT, pose_at(0, 1.5).p_CT);
}

// verifies: MOT-13
TEST(MotionEstimate, IsSeenFromAnObserverWhoHasTurned) {
  const auto motion = turning(6);
  const Eigen::Matrix3d R_IC = so3_exp(0.3 * Eigen::Vector3d::UnitZ());
  const Pose before = last_pose_seen(*motion, Eigen::Matrix3d::Identity());
  const Pose after = last_pose_seen(*motion, R_IC);
  EXPECT_TRUE((R_IC * after.R_CT).isApprox(before.R_CT));
  EXPECT_TRUE((R_IC * after.p_CT).isApprox(before.p_CT));
}

TEST(MotionEstimate, TheFirstReportedAttitudeTurnsWhatWasRemembered) {
  const auto motion = turning(6);
  const Pose seen = last_pose_seen(*motion, motion->R_IC);
  const Eigen::Quaterniond q_IC(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()));
  const auto turn = take_observer(q_IC, motion.get());
  ASSERT_TRUE(turn);
  EXPECT_TRUE(turn->isApprox(q_IC.toRotationMatrix()));
  const Pose now = last_pose_seen(*motion, motion->R_IC);
  EXPECT_TRUE(now.R_CT.isApprox(seen.R_CT)) << "in C nothing has moved";
  EXPECT_FALSE(take_observer(Eigen::Quaterniond(1.0, 0.0, 0.0, 0.0), motion.get())) << "only once";
  EXPECT_TRUE(motion->R_IC.isIdentity(0.0));
}

TEST(MotionEstimate, WhatIsNoRotationLeavesTheLastAttitude) {
  auto motion = turning(2);
  EXPECT_FALSE(take_observer(Eigen::Quaterniond(2.0, 0.0, 0.0, 0.0), motion.get()));
  EXPECT_FALSE(take_observer(Eigen::Quaterniond(std::nan(""), 0.0, 0.0, 0.0), motion.get()));
  EXPECT_FALSE(take_observer(std::nullopt, motion.get()));
  EXPECT_FALSE(motion->observer_known);
}

TEST(MotionEstimate, NoFitIsDueInPaperMode) {
  const MotionOptions paper{.mode = MotionMode::kPaper};
  auto motion = std::make_unique<MotionEstimate>();
  for (int second = 0; second < 60; ++second) {
    EXPECT_FALSE(
        remember_pose(second * kSecond_ns, pose_at(second), kCovariance, paper, motion.get()));
  }
  EXPECT_TRUE(motion->past.empty());
}

TEST(MotionEstimate, AFitIsDueOnceTheMotionHasBeenSeenForAWhile) {
  auto motion = std::make_unique<MotionEstimate>();
  bool due = false;
  for (int second = 0; second < 60; ++second) {
    due = remember_pose(second * kSecond_ns, pose_at(second), kCovariance, {}, motion.get()) || due;
  }
  EXPECT_TRUE(due);
}

TEST(MotionEstimate, ForgetsItsPosesAndKeepsTheObserver) {
  auto motion = turning(6);
  (void)take_observer(Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX())),
                      motion.get());
  const Eigen::Matrix3d R_IC = motion->R_IC;
  reset_poses(motion.get());
  EXPECT_TRUE(motion->recent.empty() && motion->past.empty());
  EXPECT_EQ(motion->R_IC, R_IC);
  EXPECT_TRUE(motion->observer_known);
  EXPECT_FALSE(rates_now(*motion, {}, {}).ok());
}

TEST(MotionEstimate, RatesAreThoseOfTheTurn) {
  const auto motion = turning(6);
  const Result<RateEstimate> rates = rates_now(*motion, {}, {});
  ASSERT_TRUE(rates.ok());
  EXPECT_TRUE(rates.value().w_T_rad_s.isApprox(kStep_rad * Eigen::Vector3d::UnitY(), 1e-6));
}

}  // namespace
}  // namespace polhode::estimator_test
