#include "solve/torque_free_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "config/limits.hpp"
#include "tumbling_attitudes.hpp"

namespace polhode::torque_free_fit_test {
namespace {

using testing::tumbling_attitudes;
using testing::TumblingAttitudes;

constexpr double kSigma_rad = 1e-3;

/// The truth, moved by two degrees, a tenth of the rate and a fifth of the moments.
RotationSolution disturbed(const TumblingAttitudes& body) {
  RotationSolution start = body.truth();
  start.reference.R_IT = so3_exp({0.02, -0.03, 0.01}) * start.reference.R_IT;
  start.reference.w_T_rad_s *= 1.05;
  start.shape += InertiaShape::Constant(0.1);
  return start;
}

TEST(RotationFit, FindsTheExactMotionFromNearIt) {
  const TumblingAttitudes body = tumbling_attitudes(60, kSigma_rad, 0.0, 1);
  RotationProblem problem = body.problem();
  problem.prior.sigma.setConstant(1e3);  // else it draws
  problem.iterations_max = 50;
  const auto found = refine_rotation(problem, disturbed(body), 0, 60);
  ASSERT_TRUE(found.ok());
  const RotationSolution& at = found.value();
  EXPECT_LT(rotation_angle_rad(at.reference.R_IT, body.reference.R_IT), 1e-5);
  EXPECT_LT((at.reference.w_T_rad_s - body.reference.w_T_rad_s).norm(), 1e-6);
  EXPECT_LT((at.shape - body.shape).norm(), 1e-3);
  EXPECT_EQ(at.inside, 60U);
  EXPECT_GT(at.iterations, 0);
  EXPECT_LT(chi2_per_dof(at), 1e-3);
}

TEST(RotationFit, TellsTheNoiseAsItIsDeclared) {
  const TumblingAttitudes body = tumbling_attitudes(120, kSigma_rad, 1.0, 2);
  const auto found = refine_rotation(body.problem(), body.truth(), 0, 120);
  ASSERT_TRUE(found.ok());
  // 349 degrees of freedom: chi-square over them scatters by 8 %, its median by 12 %.
  EXPECT_NEAR(chi2_per_dof(found.value()), 1.0, 0.25);
  EXPECT_NEAR(found.value().median2, 1.0, 0.35);
  const Eigen::Vector3d rate_error = found.value().reference.w_T_rad_s - body.reference.w_T_rad_s;
  EXPECT_LT(rate_error.norm(), 1e-4);
}

TEST(RotationFit, LeavesWrongAttitudesAside) {
  TumblingAttitudes body = tumbling_attitudes(80, kSigma_rad, 1.0, 3);
  for (std::size_t i = 4; i < body.samples.size(); i += 16) {
    body.samples[i].R_IT = so3_exp({0.3, 0.2, -0.4}) * body.samples[i].R_IT;
  }
  const auto found = refine_rotation(body.problem(), body.truth(), 0, 80);
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found.value().inside, 75U);
  EXPECT_LT((found.value().reference.w_T_rad_s - body.reference.w_T_rad_s).norm(), 2e-4);
}

TEST(RotationFit, UsesTheWindowAlone) {
  TumblingAttitudes body = tumbling_attitudes(60, kSigma_rad, 0.0, 4);
  for (std::size_t i = 30; i < 60; ++i) body.samples[i].R_IT.setIdentity();
  const auto first_half = refine_rotation(body.problem(), body.truth(), 0, 30);
  ASSERT_TRUE(first_half.ok());
  EXPECT_EQ(first_half.value().inside, 30U);
  EXPECT_LT(chi2_per_dof(first_half.value()), 1e-2);
}

TEST(RotationFit, TakesItsReferenceFromAnySample) {
  const TumblingAttitudes body = tumbling_attitudes(60, kSigma_rad, 1.0, 5);
  RotationProblem problem = body.problem();
  problem.reference = 30;
  RotationSolution start = body.truth();
  ASSERT_TRUE(advance(inertia_of(body.shape), {}, 60.0, start.reference, nullptr));
  const auto in_the_middle = refine_rotation(problem, start, 0, 60);
  const auto at_the_start = refine_rotation(body.problem(), body.truth(), 0, 60);
  ASSERT_TRUE(in_the_middle.ok() && at_the_start.ok());
  // The same minimum, seen from another time.
  EXPECT_NEAR(in_the_middle.value().chi2, at_the_start.value().chi2, 0.05);
  EXPECT_LT((in_the_middle.value().shape - at_the_start.value().shape).norm(), 1e-2);
}

TEST(RotationFit, KeepsThePriorWhereTheRotationGivesNothing) {
  // A body at rest: the prior of the shape is all that is known of it.
  TumblingAttitudes body = tumbling_attitudes(20, kSigma_rad, 0.0, 6);
  for (AttitudeSample& sample : body.samples) sample.R_IT.setIdentity();
  RotationSolution start;
  start.shape.setConstant(0.5);
  const auto found = refine_rotation(body.problem(), start, 0, 20);
  ASSERT_TRUE(found.ok());
  EXPECT_LT(found.value().shape.norm(), 0.01);
  EXPECT_NEAR(found.value().information(10, 10), 1.0 / (1.5 * 1.5), 0.05);
}

TEST(RotationFit, RefusesWindowsAndStartsThatAreNotUsable) {
  TumblingAttitudes body = tumbling_attitudes(20, kSigma_rad, 0.0, 7);
  RotationProblem problem = body.problem();
  problem.reference = 10;
  const RotationSolution truth = body.truth();
  for (const auto& [first, last] : {std::pair{11UL, 20UL}, {0UL, 10UL}, {0UL, 21UL}}) {
    EXPECT_EQ(refine_rotation(problem, truth, first, last).error().code, ErrorCode::kDegenerate);
  }
  RotationSolution runaway = truth;
  runaway.reference.w_T_rad_s = {0.0, 0.0, 1e9};
  EXPECT_EQ(refine_rotation(body.problem(), runaway, 0, 20).error().code, ErrorCode::kDegenerate);
  body.samples[3].information_I.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(refine_rotation(body.problem(), truth, 0, 20).error().code, ErrorCode::kDegenerate);
  const TumblingAttitudes many =
      tumbling_attitudes(static_cast<int>(limits::kMotionPoses) + 1, kSigma_rad, 0.0, 8);
  EXPECT_EQ(refine_rotation(many.problem(), truth, 0, limits::kMotionPoses + 1).error().code,
            ErrorCode::kDegenerate);
}

TEST(Chi2PerDof, LeavesOutTheElevenUnknowns_AndIsZeroWhereNoneIsFree) {
  EXPECT_NEAR(chi2_per_dof({.reference = {}, .chi2 = 38.0, .inside = 10}), 2.0, 1e-12);
  EXPECT_EQ(chi2_per_dof({.reference = {}, .chi2 = 38.0, .inside = 3}), 0.0);
}

}  // namespace
}  // namespace polhode::torque_free_fit_test
