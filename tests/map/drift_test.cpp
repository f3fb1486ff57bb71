#include "map/drift.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "geometry/so3.hpp"

namespace polhode::drift_test {
namespace {

constexpr double kDepthSigma = 0.06;  // of an extent, in which depth is one of three directions
const double kTurnSigma = std::sqrt(3.0) * kDepthSigma;
constexpr double kTurn_rad = 0.3;

MapDrift started(double turn_rad) {
  MapDrift drift;
  begin_drift(Eigen::Matrix3d::Identity(), turn_rad, kDepthSigma, 2.0, &drift);
  return drift;
}

double attitude_sigma_rad(const MapDrift& drift) { return std::sqrt(covariance(drift)(0, 0)); }

Pose turned(double angle_rad) {
  return {.R_CT = so3_exp({0.0, angle_rad, 0.0}), .p_CT = {0.0, 0.0, 8.0}};
}

std::unique_ptr<LocalisedFrame> keyframe(int matches, int inliers) {
  auto frame = std::make_unique<LocalisedFrame>();
  frame->matches.resize(static_cast<std::size_t>(matches));
  frame->absolute.inliers = inliers;
  frame->absolute.covariance = 1e-6 * PoseCovariance::Identity();
  return frame;
}

TEST(MapDrift, IsEmptyOfItself_BeforeAStart) {
  EXPECT_EQ(covariance(MapDrift{}), PoseCovariance::Zero());
}

TEST(MapDrift, KnowsTheStartsTurn_AsWellAsItsDepth) {
  const MapDrift drift = started(kTurn_rad);
  EXPECT_NEAR(turn_sigma(drift), kTurnSigma, 1e-12);
  EXPECT_NEAR(attitude_sigma_rad(drift), kTurnSigma * kTurn_rad, 1e-12);
  EXPECT_NEAR(std::sqrt(covariance(drift)(5, 5)), kDepthSigma * 2.0, 1e-12);
  EXPECT_LT(attitude_sigma_rad(started(1.5)), kTurnSigma * 0.5 + 1e-12)
      << "over a large turn the two are no longer exchanged";
}

TEST(MapDrift, MakesTheUnitAsUncertainAsTheStartsTurn_InRadians) {
  EXPECT_EQ(unit_sigma(MapDrift{}), 0.0);
  EXPECT_NEAR(unit_sigma(started(kTurn_rad)), kTurnSigma * kTurn_rad, 1e-12);
}

TEST(MapDrift, ForgetsTheStart_AsTheBodyTurnsOn_AndNeverGrowsByIt) {
  MapDrift drift = started(kTurn_rad);
  double last = attitude_sigma_rad(drift);
  for (double angle_rad = 0.0; angle_rad < 3.0; angle_rad += 0.2) {
    widen_turn(turned(angle_rad), &drift);
    EXPECT_LE(attitude_sigma_rad(drift), last);
    last = attitude_sigma_rad(drift);
  }
  EXPECT_NEAR(last, kTurnSigma * kTurn_rad * kTurn_rad / 2.8, 1e-9);
  widen_turn(turned(0.1), &drift);
  EXPECT_EQ(attitude_sigma_rad(drift), last) << "what was seen stays seen";
}

// verifies: MAP-08
TEST(MapDrift, WalksWithEachKeyframe_MoreWhereThereIsClutter) {
  MapDrift clean;
  MapDrift cluttered;
  for (int i = 0; i < 4; ++i) {
    add_keyframe_error(*keyframe(100, 100), &clean);
    add_keyframe_error(*keyframe(300, 100), &cluttered);
  }
  EXPECT_NEAR(attitude_sigma_rad(clean), 2e-3, 1e-12) << "the square root of four";
  EXPECT_NEAR(attitude_sigma_rad(cluttered), 2e-3 * std::sqrt(3.0), 1e-12);
}

// verifies: MAP-08
TEST(MapDrift, IsHalved_WhenItIsHeldAtBothEnds) {
  MapDrift drift;
  add_keyframe_error(*keyframe(100, 100), &drift);
  const double before = attitude_sigma_rad(drift);
  fix_both_ends(&drift);
  EXPECT_NEAR(attitude_sigma_rad(drift), 0.5 * before, 1e-15);
}

TEST(MapDrift, IsNotHalvedAgain_WhenTheSameLoopClosesOverMoreKeyframes) {
  MapDrift drift;
  add_keyframe_error(*keyframe(100, 100), &drift);
  fix_both_ends(&drift);
  const double held = attitude_sigma_rad(drift);
  fix_both_ends(&drift);
  EXPECT_EQ(attitude_sigma_rad(drift), held);
  add_keyframe_error(*keyframe(100, 100), &drift);
  const double walked = attitude_sigma_rad(drift);
  fix_both_ends(&drift);
  EXPECT_NEAR(std::pow(attitude_sigma_rad(drift), 2),
              held * held + 0.25 * (walked * walked - held * held),
              1e-15);
}

TEST(MapDrift, IsAsTheMotionTellsIt_WhateverClosesAfterwards) {
  MapDrift drift;
  add_keyframe_error(*keyframe(100, 100), &drift);
  replace_random_walk(1e-4 * PoseCovariance::Identity(), &drift);
  fix_both_ends(&drift);
  EXPECT_NEAR(attitude_sigma_rad(drift), 1e-2, 1e-12);
}

TEST(MapDrift, KeepsThePartThatTheMotionLeavesOpen_UntilTheBodyTurnsOn) {
  MapDrift drift;
  begin_drift(Eigen::Matrix3d::Identity(), 0.3, 0.1, 1.0, &drift);
  constrain_turn(0.04, 1.5, &drift);
  EXPECT_NEAR(turn_sigma(drift), 0.04, 1e-12);
  EXPECT_NEAR(unit_sigma(drift), 0.04 * 0.3, 1e-12);
  EXPECT_NEAR(covariance(drift)(5, 5), 0.04 * 0.04 / 3.0 * 1.5 * 1.5, 1e-12);
  widen_turn({.R_CT = so3_exp({0.0, 0.6, 0.0}), .p_CT = {0.0, 0.0, 5.0}}, &drift);
  EXPECT_NEAR(turn_sigma(drift), 0.02, 1e-9);
  constrain_turn(7.0, 1.5, &drift);
  EXPECT_EQ(turn_sigma(drift), 1.0) << "of what hardly turns nothing more can be open";
}

TEST(MapDrift, WhatABridgeLeavesOpenStays_UntilBothSidesOfItAreOneMap) {
  MapDrift drift = started(1.5);
  const PoseCovariance before = covariance(drift);
  add_reanchoring(0.1, 0.5, 17, &drift);
  const auto added = [&] { return PoseCovariance(covariance(drift) - before); };
  EXPECT_NEAR(added()(0, 0), 0.01, 1e-12);
  EXPECT_NEAR(added()(5, 5), 0.25, 1e-12);
  fix_both_ends(&drift);
  replace_random_walk(PoseCovariance::Zero(), &drift);
  EXPECT_NEAR(added()(0, 0), 0.01, 1e-12) << "no fit of the new part alone tells of the old T";
  EXPECT_EQ(drift.reanchored_keyframe, 17U);
  close_reanchoring(&drift);
  EXPECT_NEAR(added()(0, 0), 0.0025, 1e-12);
  EXPECT_EQ(drift.reanchored_keyframe, 0U);
}

}  // namespace
}  // namespace polhode::drift_test
