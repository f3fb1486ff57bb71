#include "solve/mass_centre_fit.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"

namespace polhode::mass_centre_fit_test {
namespace {

constexpr double kSigma = 1e-3;
const Eigen::Vector3d kCentre(0.5, -0.3, 10.0);
const Eigen::Vector3d kVelocity(0.01, 0.02, -0.03);
const Eigen::Vector3d kOffset_T(0.05, -0.03, 0.02);

TranslationVector truth() {
  TranslationVector unknowns;
  unknowns << kCentre, kVelocity, kOffset_T;
  return unknowns;
}

/// From sample to sample: about an axis of I, and about one of T.
struct Rotation {
  Eigen::Vector3d in_I_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d in_T_rad = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Matrix3d after(int steps) const {
    const double k = steps;
    return so3_exp(k * in_I_rad) * so3_exp(k * in_T_rad);
  }
};

const Rotation kTumble{.in_I_rad = {0.1, 0.2, -0.1}, .in_T_rad = {0.0, 0.05, 0.15}};
const Rotation kSpin{.in_T_rad = {0.0, 0.0, 0.2}};
const Rotation kRest{};

/// Positions of T's origin, one each 2 s.
std::vector<PositionSample> samples(int count,
                                    const Rotation& rotation,
                                    double noise_sigmas,
                                    std::uint64_t seed = 1,
                                    const Orbit& orbit = {}) {
  Rng rng(seed, 12);
  std::vector<PositionSample> out;
  for (int i = 0; i < count; ++i) {
    PositionSample sample{.time_s = 2.0 * i, .R_IT = rotation.after(i)};
    sample.information_I /= kSigma * kSigma;
    const TranslationVector unknowns = truth();
    sample.p_I =
        (translation_transition(orbit, 0.0, sample.time_s) * unknowns.head<6>()).head<3>() -
        sample.R_IT * kOffset_T +
        noise_sigmas * kSigma * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
    out.push_back(sample);
  }
  return out;
}

TranslationProblem problem_of(std::span<const PositionSample> samples, double offset_sigma) {
  return {.samples = samples,
          .orbit = {},
          .mass_centre_sigma = Eigen::Vector3d::Constant(offset_sigma)};
}

TEST(TranslationFit, RecoversTheExactPathWithoutNoise) {
  const std::vector<PositionSample> exact = samples(40, kTumble, 0.0);
  // A prior a thousand times as wide as the offset draws nothing.
  const auto path = solve_translation(problem_of(exact, 100.0));
  ASSERT_TRUE(path.ok());
  EXPECT_LT((path.value().unknowns - truth()).norm(), 1e-6);
}

TEST(TranslationFit, FollowsAnOrbit) {
  const Orbit orbit{.mean_motion_rad_s = 0.0011, .R_IH = so3_exp({0.2, 0.5, -0.1})};
  const std::vector<PositionSample> exact = samples(200, kTumble, 0.0, 1, orbit);
  const auto path = solve_translation(
      {.samples = exact, .orbit = orbit, .mass_centre_sigma = Eigen::Vector3d::Constant(100.0)});
  ASSERT_TRUE(path.ok());
  EXPECT_LT((path.value().unknowns - truth()).norm(), 1e-6);
  const auto straight = solve_translation(problem_of(exact, 100.0));
  ASSERT_TRUE(straight.ok());
  EXPECT_GT((straight.value().unknowns - truth()).norm(), 1e-3);
}

TEST(TranslationFit, IsAsSureAsItsErrorsAreSmall) {
  constexpr int kSeeds = 60;
  double chi2 = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const std::vector<PositionSample> noisy = samples(60, kTumble, 1.0, seed);
    const auto path = solve_translation(problem_of(noisy, 0.5));
    ASSERT_TRUE(path.ok());
    const TranslationVector error = path.value().unknowns - truth();
    chi2 += error.dot(path.value().information * error) / (kTranslationUnknowns * kSeeds);
  }
  // Mean of 540 squares of normal numbers: 6 % of scatter. The loss weighs normal data down a bit.
  EXPECT_GT(chi2, 0.7);
  EXPECT_LT(chi2, 1.25);
}

TEST(TranslationFit, LeavesWrongPositionsAside) {
  std::vector<PositionSample> wrong = samples(60, kTumble, 1.0);
  for (std::size_t i = 5; i < wrong.size(); i += 10) wrong[i].p_I.x() += 0.5;  // 500 sigma
  const auto path = solve_translation(problem_of(wrong, 0.5));
  ASSERT_TRUE(path.ok());
  EXPECT_LT((path.value().unknowns.head<3>() - kCentre).norm(), 3.0 * kSigma);
  EXPECT_LT((path.value().unknowns.tail<3>() - kOffset_T).norm(), 3.0 * kSigma);
}

double sigma_of(const TranslationSolution& path, Eigen::Index unknown) {
  const TranslationCovariance covariance =
      path.information.ldlt().solve(TranslationCovariance::Identity());
  return std::sqrt(covariance(unknown, unknown));
}

TEST(TranslationFit, IsEmptyOfTheOffsetOfABodyThatDoesNotRotate) {
  const std::vector<PositionSample> still = samples(40, kRest, 0.0);
  const auto path = solve_translation(problem_of(still, 0.5));
  ASSERT_TRUE(path.ok());
  EXPECT_LT(path.value().unknowns.tail<3>().norm(), 1e-3);
  EXPECT_LT((path.value().unknowns.segment<3>(3) - kVelocity).norm(), 1e-5);
  EXPECT_NEAR(sigma_of(path.value(), 8), 0.5, 1e-3);
}

TEST(TranslationFit, HoldsTheOffsetByItsPriorWhereTheRotationIsSlight) {
  // A hundredth of a degree in all: noise of a thousandth would pass for an offset of several.
  const Rotation slight{.in_I_rad = {4e-6, 0.0, 0.0}, .in_T_rad = {0.0, 4e-6, 0.0}};
  const std::vector<PositionSample> noisy = samples(40, slight, 1.0);
  const auto held = solve_translation(problem_of(noisy, 0.05));
  const auto free = solve_translation(problem_of(noisy, 1e4));
  ASSERT_TRUE(held.ok() && free.ok());
  EXPECT_LT(held.value().unknowns.tail<3>().norm(), 0.05);
  EXPECT_GT(free.value().unknowns.tail<3>().norm(), 1.0);
}

TEST(TranslationFit, OfASpinKnowsTheOffsetAcrossTheAxisAlone) {
  const std::vector<PositionSample> spun = samples(40, kSpin, 0.0);
  const auto path = solve_translation(problem_of(spun, 0.5));
  ASSERT_TRUE(path.ok());
  EXPECT_LT((path.value().unknowns.segment<2>(6) - kOffset_T.head<2>()).norm(), 1e-4);
  EXPECT_LT(sigma_of(path.value(), 6), kSigma);
  EXPECT_NEAR(sigma_of(path.value(), 8), 0.5, 1e-3);
}

TEST(TranslationFit, DependsOnTheAttitudesAsItsDerivativeSays) {
  // All attitudes off by one small rotation phi: R c moves by phi x R c, and with it the origin.
  std::vector<PositionSample> exact = samples(40, kTumble, 0.0);
  for (PositionSample& sample : exact) {
    sample.attitude_by_rotation_I.leftCols<3>().setIdentity();
  }
  const Eigen::Vector3d phi(1e-4, -2e-4, 1e-4);
  const auto before = solve_translation(problem_of(exact, 100.0));
  for (PositionSample& sample : exact) sample.R_IT = so3_exp(phi) * sample.R_IT;
  const auto after = solve_translation(problem_of(exact, 100.0));
  ASSERT_TRUE(before.ok() && after.ok());
  const TranslationVector moved = after.value().unknowns - before.value().unknowns;
  const TranslationVector expected = before.value().by_rotation.leftCols<3>() * phi;
  EXPECT_GT(expected.norm(), 1e-6);
  EXPECT_LT((moved - expected).norm(), 0.05 * expected.norm());
}

TEST(TranslationFit, NeedsFourSamplesTimeThatPassesAndAPrior) {
  std::vector<PositionSample> few = samples(4, kTumble, 0.0);
  EXPECT_EQ(solve_translation({}).error().code, ErrorCode::kTooFewObservations);
  EXPECT_EQ(solve_translation(problem_of(std::span(few).first(3), 1.0)).error().code,
            ErrorCode::kTooFewObservations);
  EXPECT_TRUE(solve_translation(problem_of(few, 1.0)).ok());
  EXPECT_EQ(solve_translation(problem_of(few, 0.0)).error().code, ErrorCode::kBadParameter);
  EXPECT_EQ(solve_translation(problem_of(few, std::nan(""))).error().code,
            ErrorCode::kBadParameter);
  std::vector<PositionSample> unusable = few;
  unusable[1].information_I.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(solve_translation(problem_of(unusable, 1.0)).error().code, ErrorCode::kDegenerate);
  for (PositionSample& sample : few) sample.time_s = 1.0;
  EXPECT_EQ(solve_translation(problem_of(few, 1.0)).error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace polhode::mass_centre_fit_test
