// The fit of a free body's rotation from nothing: no attitude, rate or inertia is given beforehand.
#include <gtest/gtest.h>

#include <cmath>

#include "config/limits.hpp"
#include "solve/torque_free_fit.hpp"
#include "tumbling_attitudes.hpp"

namespace polhode::torque_free_start_test {
namespace {

using testing::tumbling_attitudes;
using testing::TumblingAttitudes;

constexpr double kSigma_rad = 1e-3;
constexpr double kChi2Max = 1.5;  // of 3 N - 11 numbers, N >= 60: five standard deviations and more

double rate_error(const RotationSolution& found, const TumblingAttitudes& body) {
  return (found.reference.w_T_rad_s - body.reference.w_T_rad_s).norm();
}

TEST(RotationStart, FindsATumblingBodyFromNothing) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const TumblingAttitudes body = tumbling_attitudes(120, kSigma_rad, 1.0, seed);
    const auto found = solve_rotation(body.problem(), kChi2Max);
    ASSERT_TRUE(found.ok()) << seed;
    EXPECT_LT(chi2_per_dof(found.value()), kChi2Max) << seed;
    EXPECT_LT(rate_error(found.value(), body), 1e-4) << seed;
    EXPECT_LT((found.value().shape - body.shape).norm(), 0.05) << seed;
  }
}

TEST(RotationStart, IsFoundAboutAnyReference) {
  const TumblingAttitudes body = tumbling_attitudes(100, kSigma_rad, 1.0, 3);
  for (const std::size_t reference : {std::size_t{0}, std::size_t{37}, std::size_t{99}}) {
    RotationProblem problem = body.problem();
    problem.reference = reference;
    const auto found = solve_rotation(problem, kChi2Max);
    ASSERT_TRUE(found.ok()) << reference;
    EXPECT_EQ(found.value().inside, 100U) << reference;
    EXPECT_EQ(found.value().reference.time_s, body.samples[reference].time_s);
    EXPECT_LT(rotation_angle_rad(found.value().reference.R_IT, body.samples[reference].R_IT),
              6.0 * kSigma_rad);
  }
}

TEST(RotationStart, FollowsAFastBody) {
  // 40 deg from sample to sample.
  const TumblingAttitudes body = tumbling_attitudes(80, kSigma_rad, 1.0, 2, 0.35);
  const auto found = solve_rotation(body.problem(), kChi2Max);
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found.value().inside, 80U);
  EXPECT_LT(chi2_per_dof(found.value()), kChi2Max);
  EXPECT_LT(rate_error(found.value(), body), 3e-4);
}

TEST(RotationStart, OfASpinAboutOneAxisIsThatSpin) {
  TumblingAttitudes body = tumbling_attitudes(80, kSigma_rad, 0.0, 1);
  const Eigen::Vector3d w(0.0, 0.0, 0.05);
  for (AttitudeSample& sample : body.samples) sample.R_IT = so3_exp(sample.time_s * w);
  const auto found = solve_rotation(body.problem(), kChi2Max);
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found.value().inside, 80U);
  EXPECT_LT((found.value().reference.w_T_rad_s - w).norm(), 1e-5);
}

TEST(RotationStart, OfABodyAtRestIsRest) {
  TumblingAttitudes body = tumbling_attitudes(40, kSigma_rad, 0.0, 1);
  for (AttitudeSample& sample : body.samples) sample.R_IT.setIdentity();
  const auto found = solve_rotation(body.problem(), kChi2Max);
  ASSERT_TRUE(found.ok());
  EXPECT_LT(found.value().reference.w_T_rad_s.norm(), 1e-6);
}

TEST(RotationStart, HoldsOutAgainstWrongAttitudesAndAGap) {
  TumblingAttitudes body = tumbling_attitudes(120, kSigma_rad, 1.0, 4);
  for (std::size_t i = 7; i < body.samples.size(); i += 15) {
    body.samples[i].R_IT = so3_exp({0.5, -0.2, 0.3}) * body.samples[i].R_IT;
  }
  body.samples.erase(body.samples.begin() + 60, body.samples.begin() + 72);
  const auto found = solve_rotation(body.problem(), kChi2Max);
  ASSERT_TRUE(found.ok());
  EXPECT_LT(rate_error(found.value(), body), 3e-4);
  EXPECT_GE(found.value().inside, 99U);
}

TEST(RotationStart, TellsBySamplesOutsideThatAttitudesAreNotThoseOfAFreeBody) {
  // The body is pushed half way: no one motion explains both halves.
  TumblingAttitudes body = tumbling_attitudes(80, kSigma_rad, 1.0, 5);
  for (std::size_t i = 40; i < 80; ++i) {
    body.samples[i].R_IT =
        so3_exp({0.0, 0.1 * static_cast<double>(i - 39), 0.0}) * body.samples[i].R_IT;
  }
  const auto found = solve_rotation(body.problem(), kChi2Max);
  EXPECT_TRUE(!found.ok() || found.value().inside < 80U || chi2_per_dof(found.value()) > kChi2Max);
}

TEST(RotationStart, NeedsFourSamplesAndAReferenceAmongThem) {
  const TumblingAttitudes body = tumbling_attitudes(4, kSigma_rad, 0.0, 6);
  RotationProblem problem = body.problem();
  EXPECT_TRUE(solve_rotation(problem, kChi2Max).ok());
  problem.samples = problem.samples.first(3);
  EXPECT_EQ(solve_rotation(problem, kChi2Max).error().code, ErrorCode::kTooFewObservations);
  EXPECT_EQ(solve_rotation({}, kChi2Max).error().code, ErrorCode::kTooFewObservations);
  problem = body.problem();
  problem.reference = 4;
  EXPECT_EQ(solve_rotation(problem, kChi2Max).error().code, ErrorCode::kDegenerate);
  const TumblingAttitudes many =
      tumbling_attitudes(static_cast<int>(limits::kMotionPoses) + 1, kSigma_rad, 0.0, 7);
  EXPECT_EQ(solve_rotation(many.problem(), kChi2Max).error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace polhode::torque_free_start_test
