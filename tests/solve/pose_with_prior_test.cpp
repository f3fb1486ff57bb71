// A pose from a few observations and from what is expected, where the truth is known.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"
#include "solve/absolute_pose.hpp"

namespace polhode::pose_with_prior_test {
namespace {

constexpr double kSigma = 5e-4;  // half a pixel at a focal length of 1000 px
constexpr AbsolutePoseOptions kOptions{.inliers_min = 6};
// 1-sigmas of what is expected.
constexpr double kPriorTurn_rad = 0.01;
constexpr double kPriorShift = 0.02;

using Vector6 = Eigen::Matrix<double, 6, 1>;

PoseCovariance prior_covariance(double scale = 1.0) {
  Vector6 sigmas;
  sigmas << Eigen::Vector3d::Constant(scale * kPriorTurn_rad),
      Eigen::Vector3d::Constant(scale * kPriorShift);
  return sigmas.cwiseAbs2().asDiagonal();
}

Vector6 normal6(Rng* rng) {
  Vector6 v;
  for (Eigen::Index i = 0; i < 6; ++i) {
    v(i) = rng->normal();
  }
  return v;
}

Pose moved(const Pose& pose, const Vector6& by) {
  return {.R_CT = so3_exp(by.head<3>()) * pose.R_CT, .p_CT = pose.p_CT + by.tail<3>()};
}

Vector6 error_of(const Pose& estimate, const Pose& truth) {
  Vector6 e;
  e << so3_log(truth.R_CT * estimate.R_CT.transpose()), truth.p_CT - estimate.p_CT;
  return e;
}

struct Scene {
  Pose truth;
  Pose prior;  ///< the truth, off by its covariance
  std::vector<PoseObservation> observations;
  std::vector<std::uint8_t> inlier;

  Result<AbsolutePose> solve(const AbsolutePoseOptions& options = kOptions) {
    inlier.assign(observations.size(), 7);
    return pose_with_prior(observations, prior, prior_covariance(), options, inlier);
  }
  /// From the observations alone.
  Result<AbsolutePose> solve_without() {
    inlier.assign(observations.size(), 1);
    return refine_pose(observations, prior, inlier);
  }
  void shift(std::size_t i, double by_sigmas) {
    observations[i].normalised.x() += by_sigmas * kSigma;
  }
};

/// A body of radius 1 some ten radii away, seen at `count` points.
Scene make_scene(std::uint64_t seed, int count, double noise_sigmas, double prior_sigmas = 1.0) {
  Rng rng(seed, 52);
  Scene s;
  s.truth = {.R_CT = so3_exp(2.0 * normal6(&rng).head<3>()),
             .p_CT = {rng.normal(), rng.normal(), 10.0 + rng.uniform()}};
  const Vector6 off = prior_covariance().diagonal().cwiseSqrt().cwiseProduct(normal6(&rng));
  s.prior = moved(s.truth, prior_sigmas * off);
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p_T = normal6(&rng).head<3>().normalized() * std::cbrt(rng.uniform());
    const Eigen::Vector2d image =
        s.truth.to_camera(p_T).hnormalized() + noise_sigmas * kSigma * normal6(&rng).head<2>();
    s.observations.push_back({.p_T = p_T, .normalised = image, .sigma_normalised = kSigma});
  }
  return s;
}

TEST(PoseWithPrior, IsExact_WhenImagesAndExpectationAre) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Scene s = make_scene(seed, 8, 0.0, 0.0);
    const auto found = s.solve();
    ASSERT_TRUE(found.ok()) << seed;
    EXPECT_LT(error_of(found.value().pose, s.truth).norm(), 1e-9) << seed;
    EXPECT_EQ(found.value().inliers, 8);
    EXPECT_EQ(std::count(s.inlier.begin(), s.inlier.end(), 1), 8);
  }
}

TEST(PoseWithPrior, LiesNearerToTheTruthThanEitherAlone) {
  constexpr int kSeeds = 200;
  Vector6 by_both = Vector6::Zero();
  Vector6 by_prior = Vector6::Zero();
  Vector6 by_images = Vector6::Zero();
  int refused = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Scene s = make_scene(seed, 7, 1.0);
    const auto images = s.solve_without();
    const auto both = s.solve();
    ASSERT_TRUE(images.ok()) << seed;
    if (!both.ok()) {
      ++refused;
      continue;
    }
    by_both += error_of(both.value().pose, s.truth).cwiseAbs2();
    by_prior += error_of(s.prior, s.truth).cwiseAbs2();
    by_images += error_of(images.value().pose, s.truth).cwiseAbs2();
  }
  EXPECT_LE(refused, 2) << "one prior of a hundred is off by more than it should";
  // Mean squares of 600 numbers each scatter by 6 %; both together gain a fifth and more.
  EXPECT_LT(by_both.head<3>().sum(), 0.8 * by_prior.head<3>().sum());
  EXPECT_LT(by_both.head<3>().sum(), 0.8 * by_images.head<3>().sum());
  EXPECT_LT(by_both.tail<3>().sum(), 0.8 * by_prior.tail<3>().sum());
  EXPECT_LT(by_both.tail<3>().sum(), 0.8 * by_images.tail<3>().sum());
}

TEST(PoseWithPrior, KeepsOutliersOut_OfThemThoseThatThePriorAloneCannotTell) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Scene s = make_scene(seed, 11, 1.0);
    s.shift(0, 400.0);
    s.shift(1, -100.0);
    // Within reach of the prior, whose own error moves a point by some 4 sigma of an image.
    s.shift(2, 12.0);
    const auto found = s.solve();
    ASSERT_TRUE(found.ok()) << seed;
    EXPECT_EQ(s.inlier[0], 0) << seed;
    EXPECT_EQ(s.inlier[1], 0) << seed;
    EXPECT_EQ(s.inlier[2], 0) << seed;
    EXPECT_GE(found.value().inliers, 7) << seed;
    EXPECT_EQ(found.value().inliers, std::count(s.inlier.begin(), s.inlier.end(), 1)) << seed;
    const Vector6 e = error_of(found.value().pose, s.truth);
    // 99.99 % of chi-square with 6 degrees of freedom.
    EXPECT_LT(e.dot(found.value().covariance.ldlt().solve(e)), 27.9) << seed;
  }
}

TEST(PoseWithPrior, ReturnsTooFewObservations_UnderTheLeastNumberThatAgrees) {
  Scene s = make_scene(1, 6, 0.0, 0.0);
  EXPECT_TRUE(s.solve().ok());
  const auto seven = s.solve({.inliers_min = 7});
  ASSERT_FALSE(seven.ok());
  EXPECT_EQ(seven.error().code, ErrorCode::kTooFewObservations);
  s.shift(3, 400.0);
  const auto five = s.solve();
  ASSERT_FALSE(five.ok());
  EXPECT_EQ(five.error().code, ErrorCode::kTooFewObservations);
  s.observations.clear();
  const auto none = s.solve();
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::kTooFewObservations);
}

TEST(PoseWithPrior, ReturnsTooFewObservations_WhenTheExpectationIsOffByMoreThanItSays) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Scene s = make_scene(seed, 8, 1.0);
    // 0.2 to the side are ten sigma of the prior, 20 mrad in the image.
    s.prior.p_CT.x() = s.truth.p_CT.x() + 0.2;
    const auto found = s.solve();
    ASSERT_FALSE(found.ok()) << seed;
    EXPECT_EQ(found.error().code, ErrorCode::kTooFewObservations);
  }
}

TEST(PoseWithPrior, CountsNoPointBehindTheCamera) {
  Scene s = make_scene(2, 7, 0.0, 0.0);
  // Its mirror image through the camera's centre has the same image.
  s.observations[0].p_T =
      s.truth.R_CT.transpose() * (-s.truth.to_camera(s.observations[0].p_T) - s.truth.p_CT);
  const auto found = s.solve();
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(s.inlier[0], 0);
  EXPECT_EQ(found.value().inliers, 6);
}

TEST(PoseWithPrior, ReturnsDegenerate_WithAPriorWithoutAnError) {
  Scene s = make_scene(3, 8, 0.0, 0.0);
  for (const double nothing : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
    s.inlier.assign(s.observations.size(), 0);
    const auto found = pose_with_prior(
        s.observations, s.prior, nothing * PoseCovariance::Identity(), kOptions, s.inlier);
    ASSERT_FALSE(found.ok());
    EXPECT_EQ(found.error().code, ErrorCode::kDegenerate);
  }
}

TEST(PoseWithPrior, SaysWhatTheObservationsKnow_AndATenthOfThePrior) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Scene s = make_scene(seed, 8, 0.0, 0.0);  // without residuals every weight is one
    const auto images = s.solve_without();
    const auto both = s.solve();
    ASSERT_TRUE(images.ok() && both.ok()) << seed;
    const PoseCovariance expected =
        (images.value().covariance.inverse() + 0.1 * prior_covariance().inverse()).inverse();
    EXPECT_LT((both.value().covariance - expected).norm(), 1e-3 * expected.norm()) << seed;
  }
}

TEST(PoseWithPrior, PublishesAFiniteCovariance_WhereTheObservationsLeaveMuchOpen) {
  Scene s = make_scene(4, 8, 0.0, 0.0);
  for (PoseObservation& o : s.observations) {
    o = s.observations[0];  // one point indicates nothing of most of a pose
  }
  const auto found = s.solve();
  ASSERT_TRUE(found.ok());
  const PoseCovariance& covariance = found.value().covariance;
  ASSERT_TRUE(covariance.allFinite());
  const Vector6 values = Eigen::SelfAdjointEigenSolver<PoseCovariance>(covariance).eigenvalues();
  EXPECT_GT(values.minCoeff(), 0.0);
  // What is open is as wide as the prior with a tenth of its weight.
  EXPECT_NEAR(values.maxCoeff(), 10.0 * kPriorShift * kPriorShift, 1e-3 * values.maxCoeff());
}

TEST(PoseWithPrior, GrowsItsCovariance_WhenTheNoiseIsLargerThanSaid) {
  double honest = 0.0;
  double noisy = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Scene a = make_scene(seed, 40, 1.0);
    Scene b = make_scene(seed, 40, 2.5);
    const auto of_a = a.solve();
    const auto of_b = b.solve();
    ASSERT_TRUE(of_a.ok() && of_b.ok()) << seed;
    honest += of_a.value().covariance.trace();
    noisy += of_b.value().covariance.trace();
  }
  EXPECT_GT(noisy, 1.5 * honest);
}

// verifies: MAP-02
TEST(PoseWithPrior, PublishesAnHonestCovariance) {
  constexpr int kSeeds = 300;
  double sum = 0.0;
  double expected = 0.0;
  int beyond = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Scene exact = make_scene(5000 + seed, 10, 0.0, 0.0);
    const PoseCovariance of_images = exact.solve_without().value().covariance.inverse();
    const PoseCovariance of_prior = prior_covariance().inverse();
    // The error has the information of both, the published covariance a tenth of the prior's.
    expected += ((of_images + 0.1 * of_prior) * (of_images + of_prior).inverse()).trace();
    Scene s = make_scene(5000 + seed, 10, 1.0);
    const auto found = s.solve();
    ASSERT_TRUE(found.ok()) << seed;
    const Vector6 e = error_of(found.value().pose, s.truth);
    const double e2 = e.dot(found.value().covariance.ldlt().solve(e));
    sum += e2;
    beyond += e2 > 12.59 ? 1 : 0;  // 95 % of chi-square with 6 degrees of freedom
  }
  // As without a prior (AbsolutePose.PublishesAnHonestCovariance): the loss's weights lower the
  // mean to 0.79 of it, a scale of the covariance that is never under 1 lowers it further where
  // few observations scatter. The deviation of a mean of 300 is at most sqrt(12 / 300) = 0.2.
  EXPECT_LT(sum / kSeeds, expected / kSeeds + 4.0 * 0.2);
  EXPECT_GT(sum / kSeeds, 0.7 * expected / kSeeds - 4.0 * 0.2);
  // At most 5 % of 300, with a deviation of 3.8.
  EXPECT_LE(beyond, 15 + 4 * 4);
}

TEST(PoseWithPrior, GivesTheSameBytes_EachTime) {
  Scene s = make_scene(6, 9, 1.0);
  const auto first = s.solve();
  Scene other = make_scene(7, 20, 1.0);
  (void)other.solve();
  const auto second = s.solve();
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_EQ(first.value().pose.R_CT, second.value().pose.R_CT);
  EXPECT_EQ(first.value().pose.p_CT, second.value().pose.p_CT);
  EXPECT_EQ(first.value().covariance, second.value().covariance);
}

}  // namespace
}  // namespace polhode::pose_with_prior_test
