#include "motion/local_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "geometry/so3.hpp"

namespace polhode::local_fit_test {
namespace {

constexpr double kSigma = 1e-4;
const Eigen::Matrix3d kInformation = Eigen::Matrix3d::Identity() / (kSigma * kSigma);
constexpr LocalTarget kRate{.tau_s = 0.0, .derivative = 1};

/// psi = w tau + a tau^2 / 2 at equal steps up to the reference.
std::vector<RotationPoint> rotation(const Eigen::Vector3d& w, const Eigen::Vector3d& a, int count) {
  std::vector<RotationPoint> points;
  for (int i = 0; i < count; ++i) {
    const double tau = -static_cast<double>(i);
    points.push_back(
        {.tau_s = tau, .psi_rad = tau * w + 0.5 * tau * tau * a, .information = kInformation});
  }
  return points;
}

struct Body {
  Eigen::Vector3d centre{0.5, -0.3, 10.0};
  Eigen::Vector3d velocity{0.02, 0.01, -0.03};
  Eigen::Vector3d offset_T{0.05, -0.02, 0.03};
  Eigen::Vector3d w_T_rad_s{0.1, 0.15, -0.05};

  [[nodiscard]] Eigen::Matrix3d attitude(double tau) const { return so3_exp(tau * w_T_rad_s); }
  [[nodiscard]] Eigen::Vector3d origin(double tau) const {
    return centre + tau * velocity - attitude(tau) * offset_T;
  }
};

std::vector<TranslationPoint> path(const Body& body, int count) {
  std::vector<TranslationPoint> points;
  for (int i = 0; i < count; ++i) {
    const double tau = -static_cast<double>(i);
    points.push_back({.tau_s = tau,
                      .p_CT = body.origin(tau),
                      .R_CT = body.attitude(tau),
                      .information = kInformation});
  }
  return points;
}

TEST(RotationFit, OfAConstantRateIsThatRate) {
  const Eigen::Vector3d w(0.02, -0.05, 0.1);
  const auto fit = fit_rotation(rotation(w, Eigen::Vector3d::Zero(), 10), w.norm(), kRate);
  ASSERT_TRUE(fit.ok());
  EXPECT_LT((fit.value().estimate - w).norm(), 0.1 * kSigma);
  EXPECT_LT(fit.value().at_reference.norm(), 0.1 * kSigma);
  EXPECT_EQ(fit.value().points, 10U);
  EXPECT_EQ(fit.value().span_s, 9.0);
  EXPECT_NEAR(fit.value().misfit, 1.0, 0.01);
}

TEST(RotationFit, FollowsARateThatChanges_AndPredicts) {
  const Eigen::Vector3d w(0.02, -0.05, 0.1);
  const Eigen::Vector3d a(0.004, 0.002, -0.003);
  const std::vector<RotationPoint> points = rotation(w, a, 12);
  const auto rate = fit_rotation(points, w.norm(), kRate);
  ASSERT_TRUE(rate.ok());
  EXPECT_LT((rate.value().estimate - w).norm(), 10.0 * kSigma);
  const auto before = fit_rotation(points, w.norm(), {.tau_s = -5.0, .derivative = 1});
  ASSERT_TRUE(before.ok());
  EXPECT_LT((before.value().estimate - (w - 5.0 * a)).norm(), 10.0 * kSigma);
  const auto ahead = fit_rotation(points, w.norm(), {.tau_s = 1.0, .derivative = 0});
  ASSERT_TRUE(ahead.ok());
  EXPECT_LT((ahead.value().estimate - (w + 0.5 * a)).norm(), 10.0 * kSigma);
}

TEST(RotationFit, GrowsLessSureWithTheDistanceFromItsData) {
  const Eigen::Vector3d w(0.02, -0.05, 0.1);
  const std::vector<RotationPoint> points = rotation(w, Eigen::Vector3d::Zero(), 10);
  double last = 0.0;
  for (const double tau : {0.0, 1.0, 5.0, 20.0}) {
    const auto fit = fit_rotation(points, w.norm(), {.tau_s = tau, .derivative = 0});
    ASSERT_TRUE(fit.ok());
    EXPECT_GT(fit.value().covariance.trace(), last) << tau;
    last = fit.value().covariance.trace();
  }
}

TEST(RotationFit, NeedsTwoPointsAtDifferentTimesWithUsableCovariances) {
  std::vector<RotationPoint> points = rotation({0.0, 0.0, 0.1}, Eigen::Vector3d::Zero(), 4);
  EXPECT_EQ(fit_rotation({}, 0.1, kRate).error().code, ErrorCode::kTooFewObservations);
  EXPECT_EQ(fit_rotation(std::span(points).first(1), 0.1, kRate).error().code,
            ErrorCode::kTooFewObservations);
  EXPECT_TRUE(fit_rotation(std::span(points).first(2), 0.1, kRate).ok());
  std::vector<RotationPoint> no_information = points;
  for (RotationPoint& point : no_information) point.information.setZero();
  EXPECT_EQ(fit_rotation(no_information, 0.1, kRate).error().code, ErrorCode::kDegenerate);
  for (RotationPoint& point : points) point.tau_s = 0.0;
  EXPECT_EQ(fit_rotation(points, 0.1, kRate).error().code, ErrorCode::kDegenerate);
  points[1].tau_s = INFINITY;
  EXPECT_EQ(fit_rotation(points, 0.1, kRate).error().code, ErrorCode::kDegenerate);
}

TEST(TranslationFit, TellsTheCentreOfMassFromTheOriginThatCirclesIt) {
  const Body body;
  const TranslationTarget target{
      .at = kRate, .R_CT = body.attitude(0.0), .w_T_rad_s = body.w_T_rad_s};
  const auto fit = fit_translation(path(body, 20), target);
  ASSERT_TRUE(fit.ok());
  // The origin's velocity: the centre's, and that of circling it.
  const Eigen::Vector3d expected = body.velocity - body.w_T_rad_s.cross(body.offset_T);
  EXPECT_LT((fit.value().estimate - expected).norm(), 10.0 * kSigma);
  // The points have no noise; the priors' pull leaves 4 %.
  EXPECT_LT((fit.value().mass_centre_offset_T - body.offset_T).norm(), 0.1 * body.offset_T.norm());
  EXPECT_LT((fit.value().at_reference - body.origin(0.0)).norm(), 10.0 * kSigma);
}

TEST(TranslationFit, PredictsThePositionForTheAttitudeThatIsGiven) {
  const Body body;
  const TranslationTarget target{.at = {.tau_s = 2.0, .derivative = 0}, .R_CT = body.attitude(2.0)};
  const auto fit = fit_translation(path(body, 20), target);
  ASSERT_TRUE(fit.ok());
  EXPECT_LT((fit.value().estimate - body.origin(2.0)).norm(), 10.0 * kSigma);
}

TEST(TranslationFit, OfABodyThatDoesNotRotateIsAStraightLineWithoutAnOffset) {
  Body body;
  body.w_T_rad_s.setZero();
  const auto fit = fit_translation(path(body, 10), {.at = kRate});
  ASSERT_TRUE(fit.ok());
  EXPECT_LT((fit.value().estimate - body.velocity).norm(), kSigma);
  EXPECT_LT(fit.value().mass_centre_offset_T.norm(),
            1e-9);  // nothing tells of it: its prior's mean
}

TEST(TranslationFit, NeedsTwoPointsAtDifferentTimesAndARange) {
  const Body body;
  std::vector<TranslationPoint> points = path(body, 3);
  EXPECT_EQ(fit_translation({}, {}).error().code, ErrorCode::kTooFewObservations);
  EXPECT_EQ(fit_translation(std::span(points).first(1), {}).error().code,
            ErrorCode::kTooFewObservations);
  std::vector<TranslationPoint> at_camera = points;
  at_camera[0].p_CT.setZero();
  EXPECT_EQ(fit_translation(at_camera, {}).error().code, ErrorCode::kDegenerate);
  for (TranslationPoint& point : points) point.tau_s = 0.0;
  EXPECT_EQ(fit_translation(points, {}).error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace polhode::local_fit_test
