#include "solve/absolute_pose.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"

namespace polhode::absolute_pose_test {
namespace {

constexpr double kSigma = 5e-4;  // half a pixel at a focal length of 1000 px

Eigen::Vector3d normal3(Rng* rng) { return {rng->normal(), rng->normal(), rng->normal()}; }

struct Scene {
  Pose truth;
  std::vector<PoseObservation> observations;
  std::vector<std::uint8_t> outlier;
  std::vector<std::uint8_t> inlier;
};

/// A body of radius 1 some ten radii away, seen at `count` points; the first `outliers` are images
/// of nothing.
Scene make_scene(std::uint64_t seed, int count, int outliers, double noise_sigmas) {
  Rng rng(seed, 51);
  Scene s;
  s.truth = {.R_CT = so3_exp(2.0 * normal3(&rng)),
             .p_CT = {rng.normal(), rng.normal(), 10.0 + rng.uniform()}};
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p_T = normal3(&rng).normalized() * std::cbrt(rng.uniform());
    Eigen::Vector2d image = s.truth.to_camera(p_T).hnormalized();
    if (i < outliers) {
      image = {0.4 * rng.uniform() - 0.2, 0.4 * rng.uniform() - 0.2};
    }
    image += noise_sigmas * kSigma * Eigen::Vector2d(rng.normal(), rng.normal());
    s.observations.push_back({.p_T = p_T, .normalised = image, .sigma_normalised = kSigma});
    s.outlier.push_back(i < outliers ? 1 : 0);
  }
  s.inlier.resize(s.observations.size());
  return s;
}

Eigen::Matrix<double, 6, 1> error_of(const Pose& estimate, const Pose& truth) {
  Eigen::Matrix<double, 6, 1> e;
  e << so3_log(truth.R_CT * estimate.R_CT.transpose()), truth.p_CT - estimate.p_CT;
  return e;
}

/// Squared error in units of the published covariance: chi-square with 6 degrees of freedom where
/// that is honest.
double normalised_error2(const AbsolutePose& estimate, const Pose& truth) {
  const Eigen::Matrix<double, 6, 1> e = error_of(estimate.pose, truth);
  return e.dot(estimate.covariance.ldlt().solve(e));
}

TEST(AbsolutePose, IsExact_WhenTheImagesAre) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Scene s = make_scene(seed, 40, 0, 0.0);
    const auto found = absolute_pose(s.observations, nullptr, {}, s.inlier);
    ASSERT_TRUE(found.ok()) << seed;
    // Gauss-Newton ends when a step gains under 1e-6 of the cost; its last step is quadratic, so
    // the error is far below the 1e-4 rad that the weakest direction has at one sigma.
    EXPECT_LT(error_of(found.value().pose, s.truth).norm(), 1e-7) << seed;
    EXPECT_EQ(found.value().inliers, 40);
    EXPECT_NEAR((found.value().pose.R_CT * found.value().pose.R_CT.transpose() -
                 Eigen::Matrix3d::Identity())
                    .norm(),
                0.0,
                1e-12);
  }
}

// verifies: MAP-01
TEST(AbsolutePose, FindsThePose_WhenHalfOfTheMatchesAreOutliers) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Scene s = make_scene(seed, 100, 50, 1.0);
    const auto found = absolute_pose(s.observations, nullptr, {.seed = seed}, s.inlier);
    ASSERT_TRUE(found.ok()) << seed;
    // 99.99 % bound of chi-square with 6 degrees of freedom, and one or two chance inliers among
    // the outliers.
    EXPECT_LT(normalised_error2(found.value(), s.truth), 2.0 * 27.9) << seed;
    int right = 0;
    int wrong = 0;
    for (std::size_t i = 0; i < s.inlier.size(); ++i) {
      right += s.inlier[i] != 0 && s.outlier[i] == 0 ? 1 : 0;
      wrong += s.inlier[i] != 0 && s.outlier[i] != 0 ? 1 : 0;
    }
    // 50 good ones: four sigma hold all but 0.03 %. An outlier lies within 4 sigma of its place (2
    // mrad in a field of 400 mrad) with a probability of 8e-5.
    EXPECT_GE(right, 48) << seed;
    EXPECT_LE(wrong, 1) << seed;
  }
}

TEST(AbsolutePose, CountsItsInliers) {
  Scene s = make_scene(7, 100, 30, 1.0);
  const auto found = absolute_pose(s.observations, nullptr, {}, s.inlier);
  ASSERT_TRUE(found.ok());
  EXPECT_NEAR(found.value().inliers,
              static_cast<double>(std::count(s.inlier.begin(), s.inlier.end(), 1)),
              2.0)
      << "the last round of flags may differ by what lies on the limit";
}

// verifies: MAP-02
TEST(AbsolutePose, PublishesAnHonestCovariance) {
  constexpr int kSeeds = 200;
  double sum = 0.0;
  int beyond = 0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    Scene s = make_scene(1000 + seed, 60, 0, 1.0);
    const auto found = absolute_pose(s.observations, nullptr, {.seed = seed}, s.inlier);
    ASSERT_TRUE(found.ok());
    const double e2 = normalised_error2(found.value(), s.truth);
    sum += e2;
    beyond += e2 > 12.59 ? 1 : 0;  // 95 % of chi-square with 6 degrees of freedom
  }
  // Exact covariances give a mean of 6 with a deviation of sqrt(12 / 200) = 0.245. The Cauchy
  // weights (scale 2) have a mean of 0.72 on normal residuals, the published covariance is the
  // inverse of the weighted information, 1.38 times that of least squares, while the estimator's
  // own is 1.09 times: so the mean is 6 * 0.79 = 4.7. Between that and 6 is honest; four deviations
  // on both sides.
  EXPECT_GT(sum / kSeeds, 4.7 - 4.0 * 0.245);
  EXPECT_LT(sum / kSeeds, 6.0 + 4.0 * 0.245);
  // 5 % of 200 with a deviation of 3.1.
  EXPECT_LE(beyond, 10 + 4 * 3);
}

TEST(AbsolutePose, GrowsItsCovariance_WhenTheNoiseIsLargerThanSaid) {
  Scene honest = make_scene(3, 200, 0, 1.0);
  Scene noisy = make_scene(3, 200, 0, 2.5);
  const auto a = absolute_pose(honest.observations, nullptr, {}, honest.inlier);
  const auto b = absolute_pose(noisy.observations, nullptr, {}, noisy.inlier);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_GT(b.value().covariance.trace(), 1.5 * a.value().covariance.trace());
}

TEST(AbsolutePose, TakesAGoodHint_WhereChanceAloneCannotSucceed) {
  Scene s = make_scene(8, 200, 184, 1.0);  // 16 good ones of 200: one draw in 2000 is clean
  const AbsolutePoseOptions options{.iterations_max = 10, .inliers_min = 12};
  EXPECT_FALSE(absolute_pose(s.observations, nullptr, options, s.inlier).ok());
  const auto hinted = absolute_pose(s.observations, &s.truth, options, s.inlier);
  ASSERT_TRUE(hinted.ok());
  EXPECT_LT(normalised_error2(hinted.value(), s.truth), 2.0 * 27.9);
}

TEST(AbsolutePose, IsNotMisled_WhenTheHintIsWrong) {
  Scene s = make_scene(9, 80, 20, 1.0);
  const Pose wrong{.R_CT = so3_exp({0.3, -0.2, 0.1}) * s.truth.R_CT, .p_CT = 1.3 * s.truth.p_CT};
  const auto found = absolute_pose(s.observations, &wrong, {}, s.inlier);
  ASSERT_TRUE(found.ok());
  EXPECT_LT(normalised_error2(found.value(), s.truth), 2.0 * 27.9);
}

TEST(AbsolutePose, ReturnsTooFewObservations_UnderTheLeastNumberOfInliers) {
  Scene s = make_scene(10, 11, 0, 0.0);
  const auto found = absolute_pose(s.observations, nullptr, {.inliers_min = 12}, s.inlier);
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error().code, ErrorCode::kTooFewObservations);
  const auto none = absolute_pose({}, nullptr, {}, {});
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::kTooFewObservations);
}

TEST(AbsolutePose, ReturnsNoConsensus_WhenAllMatchesAreOutliers) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Scene s = make_scene(seed, 100, 100, 1.0);
    const auto found = absolute_pose(s.observations, nullptr, {}, s.inlier);
    ASSERT_FALSE(found.ok()) << seed;
    EXPECT_EQ(found.error().code, ErrorCode::kNoConsensus) << seed;
  }
}

TEST(AbsolutePose, GivesAnError_WhenAllPointsCoincide) {
  Scene s = make_scene(11, 40, 0, 0.0);
  for (PoseObservation& o : s.observations) {
    o = s.observations[0];
  }
  EXPECT_FALSE(absolute_pose(s.observations, nullptr, {}, s.inlier).ok());
}

TEST(AbsolutePose, IsDegenerate_WhereTsOriginLiesBehindTheCamera) {
  Scene s = make_scene(13, 60, 0, 1.0);
  // The same images by points far from T's origin: all are before the camera, the origin is not.
  const Eigen::Vector3d shift_T = s.truth.R_CT.transpose() * Eigen::Vector3d(0.0, 0.0, 15.0);
  for (PoseObservation& o : s.observations) {
    o.p_T += shift_T;
  }
  const auto found = absolute_pose(s.observations, nullptr, {}, s.inlier);
  ASSERT_FALSE(found.ok());
  EXPECT_EQ(found.error().code, ErrorCode::kDegenerate);
}

TEST(AbsolutePose, GivesTheSameBytes_ForTheSameSeed_AfterOtherCalls) {
  Scene s = make_scene(12, 100, 40, 1.0);
  const AbsolutePoseOptions options{.seed = 5, .stream = 77};
  const auto first = absolute_pose(s.observations, nullptr, options, s.inlier);
  Scene other = make_scene(13, 60, 20, 1.0);
  (void)absolute_pose(other.observations, nullptr, {.seed = 1}, other.inlier);
  const auto second = absolute_pose(s.observations, nullptr, options, s.inlier);
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_EQ(first.value().pose.R_CT, second.value().pose.R_CT);
  EXPECT_EQ(first.value().pose.p_CT, second.value().pose.p_CT);
  EXPECT_EQ(first.value().covariance, second.value().covariance);
}

TEST(RefinePose, UsesOnlyTheFlaggedObservations) {
  Scene s = make_scene(14, 60, 30, 0.0);
  for (std::size_t i = 0; i < s.inlier.size(); ++i) {
    s.inlier[i] = s.outlier[i] == 0 ? 1 : 0;
  }
  const Pose near{.R_CT = so3_exp({0.01, -0.02, 0.01}) * s.truth.R_CT,
                  .p_CT = s.truth.p_CT + Eigen::Vector3d(0.02, 0.01, -0.1)};
  const auto found = refine_pose(s.observations, near, s.inlier);
  ASSERT_TRUE(found.ok());
  EXPECT_LT(error_of(found.value().pose, s.truth).norm(), 1e-7);
  EXPECT_EQ(found.value().inliers, 30);
}

TEST(RefinePose, ReturnsAnError_UnderFourObservations) {
  Scene s = make_scene(15, 20, 0, 0.0);
  std::fill(s.inlier.begin(), s.inlier.end(), std::uint8_t{0});
  EXPECT_FALSE(refine_pose(s.observations, s.truth, s.inlier).ok());
  s.inlier[0] = s.inlier[1] = s.inlier[2] = 1;
  const auto three = refine_pose(s.observations, s.truth, s.inlier);
  ASSERT_FALSE(three.ok());
  EXPECT_EQ(three.error().code, ErrorCode::kTooFewObservations);
}

}  // namespace
}  // namespace polhode::absolute_pose_test
