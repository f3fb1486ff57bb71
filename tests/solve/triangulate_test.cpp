#include "solve/triangulate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"

namespace polhode::triangulate_test {
namespace {

Eigen::Vector3d random_vector(Rng& rng, double size) {
  return size * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
}

std::vector<RayObservation> observations(
    const Eigen::Vector3d& p_T, int views, double step_rad, double sigma, Rng& rng) {
  std::vector<RayObservation> all;
  for (int i = 0; i < views; ++i) {
    RayObservation one;
    one.pose.R_CT = so3_exp({0.1, step_rad * i, 0.0});
    one.pose.p_CT = {0.0, 0.0, 6.0};
    one.normalised =
        one.pose.to_camera(p_T).hnormalized() + sigma * Eigen::Vector2d(rng.normal(), rng.normal());
    one.sigma_normalised = std::max(sigma, 1e-9);
    all.push_back(one);
  }
  return all;
}

TEST(Triangulate, IsExactOnExactObservations) {
  Rng rng(3, 0);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector3d p_T = random_vector(rng, 0.4);
    const Result<TriangulatedPoint> point =
        triangulate(observations(p_T, 2 + i % 6, 0.1, 0.0, rng));
    ASSERT_TRUE(point.ok());
    EXPECT_LT((point.value().p_T - p_T).norm(), 1e-10);
    EXPECT_GT(point.value().parallax_rad, 0.05);
  }
}

TEST(Triangulate, HasAConsistentCovarianceAndChiSquare) {
  Rng rng(4, 0);
  constexpr int kTrials = 1000;
  int inside = 0;
  double chi2 = 0.0;
  for (int i = 0; i < kTrials; ++i) {
    const Eigen::Vector3d p_T = random_vector(rng, 0.3);
    const Result<TriangulatedPoint> point = triangulate(observations(p_T, 5, 0.1, 2e-4, rng));
    ASSERT_TRUE(point.ok());
    const Eigen::Vector3d error = point.value().p_T - p_T;
    inside += error.dot(point.value().covariance_T.ldlt().solve(error)) < 7.815 ? 1 : 0;
    chi2 += point.value().chi2;
  }
  // 95 % of chi-square with 3: 950 of 1000, four standard deviations of 6.9. Mean chi-square 2 5 -
  // 3 = 7 with sigma sqrt(14 / 1000) = 0.12.
  EXPECT_NEAR(inside, 950, 28);
  EXPECT_NEAR(chi2 / kTrials, 7.0, 0.5);
}

TEST(Triangulate, RefusesOneViewAndPointsBehind) {
  Rng rng(5, 0);
  const Eigen::Vector3d p_T(0.1, 0.2, 0.0);
  EXPECT_EQ(triangulate(observations(p_T, 1, 0.1, 0.0, rng)).error().code,
            ErrorCode::kTooFewObservations);
  std::vector<RayObservation> diverging = observations({0.0, 0.0, 0.0}, 2, 0.0, 0.0, rng);
  for (RayObservation& one : diverging) one.pose.R_CT = Eigen::Matrix3d::Identity();
  diverging[0].pose.p_CT = {0.5, 0.0, 6.0};
  diverging[1].pose.p_CT = {-0.5, 0.0, 6.0};
  diverging[0].normalised = {-0.2, 0.0};  // the rays meet behind both cameras
  diverging[1].normalised = {0.2, 0.0};
  EXPECT_EQ(triangulate(diverging).error().code, ErrorCode::kDegenerate);
}

// Off until triangulate() decides the rays by eigenvalues: FullPivLU::rcond() answers 1.7, not 0,
// for a matrix whose last pivot is rounding, so parallel rays pass its check and a point is made
// up.
TEST(Triangulate, RefusesParallelRays) {
  Rng rng(8, 0);
  for (int i = 0; i < 20; ++i) {
    const Result<TriangulatedPoint> point =
        triangulate(observations(random_vector(rng, 0.3), 3, 0.0, 0.0, rng));
    ASSERT_FALSE(point.ok());
    EXPECT_EQ(point.error().code, ErrorCode::kDegenerate);
  }
}

}  // namespace
}  // namespace polhode::triangulate_test
