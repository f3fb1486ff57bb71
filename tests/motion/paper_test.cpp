#include "motion/paper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "free_body.hpp"
#include "motion/trajectory.hpp"

namespace polhode::paper_test {
namespace {

constexpr double kTau = 2.0 * std::numbers::pi;

TEST(PaperRate, IsTheRotationBetweenTwoPosesOverTheirTimeAtTheMiddle) {
  FreeBody body;
  body.w_T_rad_s = {0.01, 0.02, -0.03};
  body.R_CT = so3_exp({0.3, 0.1, 0.9});
  body.v_mass_centre_C = {0.1, 0.0, -0.5};
  const std::vector<TruthSample> truth = tumble(body, 2, 4.0);
  const PoseSample first{.timestamp_ns = truth[0].timestamp_ns,
                         .pose = truth[0].pose,
                         .covariance = PoseCovariance::Identity()};
  const PoseSample second{.timestamp_ns = truth[1].timestamp_ns,
                          .pose = truth[1].pose,
                          .covariance = PoseCovariance::Identity()};
  const Result<PaperRate> rate = paper_rate(first, second);
  ASSERT_TRUE(rate.ok());
  EXPECT_LT((rate.value().w_T_rad_s - body.w_T_rad_s).norm(), 1e-10);
  EXPECT_LT((rate.value().v_C - body.v_mass_centre_C).norm(), 1e-12);
  EXPECT_EQ(rate.value().timestamp_ns, first.timestamp_ns + 2'000'000'000);
  const double radial = ((Eigen::Vector3d(0.4, 0.0, 8.0)).norm() - 10.0) / 4.0;
  EXPECT_NEAR(rate.value().radial_speed, radial, 1e-12);
  EXPECT_NEAR(rate.value().sigma_radial, std::sqrt(2.0) / 4.0, 1e-12);
  EXPECT_EQ(paper_rate(second, first).error().code, ErrorCode::kDegenerate);
  EXPECT_EQ(paper_rate(first, first).error().code, ErrorCode::kDegenerate);
}

// verifies: MOT-02
TEST(PaperRate, StampedAtTheMiddleIsBetterThanAtEitherEnd) {
  const std::vector<TruthSample> truth = tumble(paper_body(), 200, 10.0);
  const std::vector<TruthSample> middles = [] {
    FreeBody body = paper_body();
    advance(body, 5.0);
    return tumble(body, 199, 10.0);
  }();
  double at_middle = 0.0;
  double at_end = 0.0;
  for (std::size_t i = 0; i + 1 < truth.size(); ++i) {
    const PaperRate rate =
        paper_rate({.timestamp_ns = truth[i].timestamp_ns, .pose = truth[i].pose},
                   {.timestamp_ns = truth[i + 1].timestamp_ns, .pose = truth[i + 1].pose})
            .value();
    at_middle += (rate.w_T_rad_s - middles[i].w_T_rad_s).squaredNorm();
    at_end += (rate.w_T_rad_s - truth[i + 1].w_T_rad_s).squaredNorm();
  }
  // The wobble of 0.1 deg/s at 0.957 deg/s changes by 0.1 sin(4.8 deg) = 0.0083 deg/s in half an
  // interval, over two components 0.0059 deg/s RMS each.
  const double end_deg_s = std::sqrt(at_end / 199.0 / 2.0) / kDegree_rad;
  EXPECT_NEAR(end_deg_s, 0.0059, 0.0003);
  EXPECT_LT(std::sqrt(at_middle / 199.0 / 2.0) / kDegree_rad, 0.0003);
}

// verifies: MOT-04
TEST(Drift, FindsVelocityAndMassCentreWithHonestSigmas) {
  const FreeBody body = asymmetric_body(10.0 * kDegree_rad);
  const std::vector<TruthSample> truth = tumble(body, 100, 1.0);
  int beyond = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Result<DriftFit> fit = fit_drift(observed(truth, {}, seed), 0.5);
    ASSERT_TRUE(fit.ok());
    for (Eigen::Index k = 0; k < 3; ++k) {
      beyond += std::abs(fit.value().v_C(k) - body.v_mass_centre_C(k)) >
                        1.96 * std::sqrt(fit.value().covariance_v_C(k, k))
                    ? 1
                    : 0;
      beyond += std::abs(fit.value().c_T(k) - body.mass_centre_T(k)) >
                        1.96 * std::sqrt(fit.value().covariance_c_T(k, k))
                    ? 1
                    : 0;
    }
    EXPECT_NEAR(fit.value().chi2_per_dof, 1.0, 0.4);
  }
  // 18 of 360 expected, standard deviation 4.1 (parameters of one run are correlated).
  EXPECT_LE(beyond, 36);
}

TEST(Drift, OfAPureSpinDoesNotClaimTheMassCentreAlongTheAxis) {
  FreeBody body;
  body.w_T_rad_s = {0.0, 0.0, 0.2};
  body.R_CT = so3_exp({0.7, 0.2, 0.0});
  body.mass_centre_T = {0.05, 0.02, 0.08};
  const std::vector<PoseSample> poses = observed(tumble(body, 100, 1.0), {}, 1);
  std::vector<SineSample> workspace(100);
  const Result<MotionModel> model = paper_model(poses, 0.5, workspace);
  ASSERT_TRUE(model.ok());
  ASSERT_TRUE(model.value().drift_valid);
  EXPECT_EQ(model.value().mass_centre_axes[0], Observability::kObserved);
  EXPECT_EQ(model.value().mass_centre_axes[1], Observability::kObserved);
  EXPECT_EQ(model.value().mass_centre_axes[2], Observability::kUnobserved);
  EXPECT_GT(std::abs(model.value().mass_centre_axes_T(2, 2)), 0.999);  // the spin axis
  for (const SineFit& sine : model.value().sines) {
    EXPECT_FALSE(sine.observed);
  }
  EXPECT_NEAR(model.value().rotation_period_s, kTau / 0.2, 0.05);
}

TEST(Drift, OfABodyAtRestClaimsNoMassCentreAndNoPeriod) {
  FreeBody body;
  const std::vector<PoseSample> poses = observed(tumble(body, 60, 1.0), {}, 2);
  std::vector<SineSample> workspace(60);
  const Result<MotionModel> model = paper_model(poses, 0.5, workspace);
  ASSERT_TRUE(model.ok());
  for (const Observability one : model.value().mass_centre_axes) {
    EXPECT_EQ(one, Observability::kUnobserved);
  }
  EXPECT_EQ(model.value().rotation_period_s, 0.0);
  EXPECT_LT(model.value().drift.speed, 5.0 * worst_sigma(model.value().drift.covariance_v_C));
}

TEST(Drift, IsAnErrorWhereItCannotBeSolved) {
  const std::vector<PoseSample> poses = observed(tumble(paper_body(), 10, 1.0), {}, 3);
  EXPECT_EQ(fit_drift(std::span(poses).first(3), 0.5).error().code, ErrorCode::kTooFewObservations);
  EXPECT_EQ(fit_drift(poses, 0.0).error().code, ErrorCode::kBadParameter);
  std::vector<PoseSample> bad = poses;
  bad[2].covariance.setZero();
  EXPECT_EQ(fit_drift(bad, 0.5).error().code, ErrorCode::kDegenerate);
}

// verifies: MOT-03
TEST(PaperModel, OfThePapersCaseHasItsPeriodsAndSpeed) {
  const std::vector<PoseSample> poses = observed(tumble(paper_body(), 300, 10.0), {}, 5);
  std::vector<SineSample> workspace(299);
  const Result<MotionModel> model = paper_model(poses, 0.5, workspace);
  ASSERT_TRUE(model.ok());
  // Nutation in the body: (1 - 0.02 / 0.47) 1 deg/s, 376 s. The paper reports errors of 0.043 % and
  // 0.006 %.
  const double period_s = 360.0 / (1.0 - 0.02 / 0.47);
  for (const std::size_t k : {0U, 1U}) {
    ASSERT_TRUE(model.value().sines[k].observed);
    EXPECT_NEAR(model.value().sines[k].period_s, period_s, 0.0005 * period_s);
    EXPECT_NEAR(model.value().sines[k].amplitude, 0.1 * kDegree_rad, 0.003 * kDegree_rad);
  }
  EXPECT_FALSE(model.value().sines[2].observed);
  EXPECT_NEAR(model.value().mean_w_T_rad_s.z(), kDegree_rad, 1e-5);
  EXPECT_NEAR(model.value().drift.speed, 0.0045, 0.00001);
}

TEST(PaperModel, NeedsPosesAndRoom) {
  const std::vector<PoseSample> poses = observed(tumble(paper_body(), 10, 10.0), {}, 6);
  std::vector<SineSample> workspace(8);
  EXPECT_EQ(paper_model(poses, 0.5, workspace).error().code, ErrorCode::kMemoryTooSmall);
  EXPECT_EQ(paper_model(std::span(poses).first(1), 0.5, workspace).error().code,
            ErrorCode::kTooFewObservations);
  const Result<MotionModel> two = paper_model(std::span(poses).first(2), 0.5, workspace);
  ASSERT_TRUE(two.ok());
  EXPECT_FALSE(two.value().drift_valid);
  EXPECT_FALSE(two.value().sines[0].observed);
}

}  // namespace
}  // namespace polhode::paper_test
