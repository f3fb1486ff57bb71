#include "map/reanchor.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <vector>

#include "geometry/so3.hpp"

namespace polhode::reanchor_test {
namespace {

/// T' against T: axes, origin and unit are all different.
Similarity truth() {
  return {
      .scale = 0.8, .R_ba = so3_exp({0.7, -1.1, 0.4}), .t_ba = Eigen::Vector3d(0.1, 0.05, -0.45)};
}

const ReanchorBody kBody{.centre_T = Eigen::Vector3d::Zero(), .radius_mu = 1.0};

/// A body 8 units away that turns by `turn_rad` over nine frames, so that the new landmarks' middle
/// faces the camera in the last.
std::vector<ReanchorFrame> frames(double turn_rad, double predicted_rate = 1.0) {
  std::vector<ReanchorFrame> all;
  const Eigen::Matrix3d facing =
      Eigen::Quaterniond::FromTwoVectors(truth().t_ba.normalized(), -Eigen::Vector3d::UnitZ())
          .toRotationMatrix();
  const Similarity inverse{.scale = 1.0 / truth().scale,
                           .R_ba = truth().R_ba.transpose(),
                           .t_ba = -(truth().R_ba.transpose() * truth().t_ba) / truth().scale};
  for (int i = 0; i < 9; ++i) {
    const Eigen::Vector3d turned = (i - 8) / 8.0 * turn_rad * Eigen::Vector3d(0.1, 0.99, 0.05);
    const Pose is{.R_CT = so3_exp(turned) * facing, .p_CT = {0.1, 0.02 * i, 8.0}};
    const Pose thought{.R_CT = so3_exp(predicted_rate * turned) * facing, .p_CT = is.p_CT};
    all.push_back({.start = transformed(is, inverse),
                   .predicted = thought,
                   .predicted_sigma_rad = 0.01,
                   .predicted_sigma_mu = 0.02});
  }
  return all;
}

TEST(Reanchoring, IsExact_WhenThePredictionIs) {
  const auto all = frames(0.6);
  const Result<Reanchoring> found = reanchor_map(all, kBody);
  ASSERT_TRUE(found.ok());
  const Reanchoring& reanchoring = found.value();
  EXPECT_LT(rotation_angle_rad(reanchoring.to_T.R_ba, truth().R_ba), 1e-9);
  // The body's near face is thought half a radius from its centre and is 0.46: a few hundredths of
  // the radius stay, whatever the turn shows.
  EXPECT_LT((reanchoring.to_T.t_ba - truth().t_ba).norm(), 0.05 * kBody.radius_mu);
  EXPECT_NEAR(reanchoring.to_T.scale, truth().scale, 0.01 * truth().scale);
  EXPECT_LT(reanchoring.misfit_rad, 1e-9);
  EXPECT_NEAR(reanchoring.turn_rad, 0.6, 0.01);
  EXPECT_TRUE(reanchoring.agrees);
}

TEST(Reanchoring, KeepsTheOriginOnTheBody_WhenTheTurnGivesNothingOfItsDepth) {
  const auto all = frames(1e-4);
  const Result<Reanchoring> found = reanchor_map(all, kBody);
  ASSERT_TRUE(found.ok());
  EXPECT_LT((found.value().to_T.t_ba - kBody.centre_T).norm(), kBody.radius_mu);
}

TEST(Reanchoring, SaysThatTheMotionsContradict_WhenTheyTurnByDifferentRates) {
  EXPECT_TRUE(reanchor_map(frames(0.6, 0.9), kBody).value().agrees);
  EXPECT_FALSE(reanchor_map(frames(0.6, 0.7), kBody).value().agrees) << "disturbed meanwhile";
  const Result<Reanchoring> mirrored = reanchor_map(frames(0.6, -1.0), kBody);
  ASSERT_TRUE(mirrored.ok());
  EXPECT_FALSE(mirrored.value().agrees);
  EXPECT_GT(mirrored.value().misfit_rad, 0.2);
}

TEST(Reanchoring, SaysThatTheMotionsContradict_ThoughThePhaseIsHardlyKnown) {
  // A start of 16 deg against its mirror image: 0.18 rad of misfit. An error of the phase that all
  // frames share is part of the rotation from T' to T and excuses none of it.
  auto all = frames(0.28, -1.0);
  for (ReanchorFrame& frame : all) frame.predicted_sigma_rad = 0.145;
  EXPECT_FALSE(reanchor_map(all, kBody).value().agrees);
  EXPECT_GT(reanchor_map(all, kBody).value().misfit_rad, 0.15);
  // One that grows by 0.4 rad over the start does: the rate is not known.
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].predicted_sigma_rad = 0.1 + 0.05 * static_cast<double>(i);
  }
  EXPECT_TRUE(reanchor_map(all, kBody).value().agrees);
}

TEST(Reanchoring, DoesNotHold_WhereTheBodyMayHaveTurnedByAnything) {
  auto all = frames(0.6);
  for (ReanchorFrame& frame : all) frame.predicted_sigma_rad = 0.9;
  EXPECT_TRUE(reanchor_map(all, kBody).value().agrees);
  for (ReanchorFrame& frame : all) frame.predicted_sigma_rad = 1.1;
  EXPECT_FALSE(reanchor_map(all, kBody).value().agrees) << "however alike the rates are";
}

TEST(Reanchoring, DoesNotHold_WhereThePredictionEndsAnywhere) {
  std::vector<ReanchorFrame> all = frames(0.6, 0.9);
  all.back().predicted_sigma_rad = 0.9;
  EXPECT_TRUE(reanchor_map(all, kBody).value().agrees);
  all.back().predicted_sigma_rad = 3.5;  // of a body that is turned by hand
  EXPECT_FALSE(reanchor_map(all, kBody).value().agrees);
}

TEST(Reanchoring, RefusesWhatItCannotUse) {
  const auto all = frames(0.6);
  EXPECT_EQ(reanchor_map(std::span(all).first(2), kBody).error().code,
            ErrorCode::kTooFewObservations);
  EXPECT_EQ(reanchor_map(all, {.radius_mu = 0.0}).error().code, ErrorCode::kDegenerate);
  auto without_sigma = all;
  without_sigma[3].predicted_sigma_rad = 0.0;
  EXPECT_EQ(reanchor_map(without_sigma, kBody).error().code, ErrorCode::kDegenerate);
  without_sigma = all;
  without_sigma[3].predicted_sigma_mu = 0.0;
  EXPECT_EQ(reanchor_map(without_sigma, kBody).error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace polhode::reanchor_test
