#include "shape/cloud.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "surfaces.hpp"

namespace polhode::cloud_test {
namespace {

Cloud cloud_of(const Points& points) {
  Cloud cloud;
  for (const Eigen::Vector3d& point : points) {
    EXPECT_TRUE(cloud.points_T.push_back(point));
  }
  cloud.measured = points.size();
  return cloud;
}

std::size_t neighbours_by_force(const Points& points, std::size_t i, double radius) {
  std::size_t count = 0;
  for (std::size_t j = 0; j < points.size(); ++j) {
    count += j != i && (points[j] - points[i]).norm() <= radius ? 1U : 0U;
  }
  return count;
}

TEST(Spacing, IsHalfTheInverseRootOfTheDensityOnASurface) {
  // Points at random with density rho have a mean nearest distance of 0.5 / sqrt(rho); the median
  // of the fourth nearest lies 3 % under its mean. 2000 points on 1 x 1: 0.5 / sqrt(2000) =
  // 0.01118. Points near the rim have fewer neighbours.
  const Points points =
      box_points({1.0, 1.0, 0.0}, {false, false, false, false, true, false}, 2000, 0.0, 1);
  const Result<double> spacing = median_spacing(points);
  ASSERT_TRUE(spacing.ok());
  EXPECT_NEAR(spacing.value(), 0.01118, 0.08 * 0.01118);
}

TEST(Spacing, IsNotFooledByPairsOfPointsThatAllButCoincide) {
  const Points points =
      box_points({1.0, 1.0, 0.0}, {false, false, false, false, true, false}, 1000, 0.0, 1);
  Points doubled = points;
  for (const Eigen::Vector3d& point : points) {
    doubled.push_back(point + Eigen::Vector3d(1e-9, 0.0, 0.0));
  }
  const double single = median_spacing(points).value();
  const double twice = median_spacing(doubled).value();
  EXPECT_GT(twice, 0.5 * single);
  EXPECT_LT(twice, single);
}

TEST(Spacing, IsAnErrorForTooFewOrCoincidingPoints) {
  EXPECT_EQ(median_spacing(Points(4, Eigen::Vector3d::Zero())).error().code,
            ErrorCode::kTooFewObservations);
  EXPECT_EQ(median_spacing(Points(50, Eigen::Vector3d::Ones())).error().code,
            ErrorCode::kDegenerate);
}

TEST(Outliers, AreExactlyThePointsWithTooFewNeighboursInOrder) {
  Points points = box_points({1.0, 0.7, 0.5}, kAllSides, 400, 0.02, 4);
  add_strays(points, 60, 1.5, 4);
  constexpr double kRadius = 0.11;
  constexpr int kNeighbours = 4;
  Points expected;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (neighbours_by_force(points, i, kRadius) >= kNeighbours) {
      expected.push_back(points[i]);
    }
  }
  Cloud cloud = cloud_of(points);
  CloudScratch scratch;
  EXPECT_EQ(remove_outliers(kRadius, kNeighbours, scratch, cloud), points.size() - expected.size());
  ASSERT_EQ(cloud.points_T.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(cloud.points_T[i], expected[i]);
  }
}

// verifies: SHP-02
TEST(Homogenise, LeavesOnePointACubeAndKeepsTheWeightedMean) {
  const Points points = box_points({1.0, 0.7, 0.5}, kAllSides, 3000, 0.01, 5);
  Cloud cloud = cloud_of(points);
  CloudScratch scratch;
  constexpr double kEdge = 0.1;
  homogenise(kEdge, scratch, cloud);
  const auto cube = [](const Eigen::Vector3d& p) {
    return std::array<int, 3>{static_cast<int>(std::floor(p.x() / kEdge)),
                              static_cast<int>(std::floor(p.y() / kEdge)),
                              static_cast<int>(std::floor(p.z() / kEdge))};
  };
  std::vector<std::array<int, 3>> cubes;
  std::vector<std::array<int, 3>> before;
  for (const Eigen::Vector3d& p : cloud.points_T) cubes.push_back(cube(p));
  for (const Eigen::Vector3d& p : points) before.push_back(cube(p));
  std::sort(cubes.begin(), cubes.end());
  EXPECT_EQ(std::adjacent_find(cubes.begin(), cubes.end()), cubes.end());
  std::sort(before.begin(), before.end());
  before.erase(std::unique(before.begin(), before.end()), before.end());
  EXPECT_EQ(cubes, before);
}

TEST(Homogenise, EvensOutADenseHalf) {
  Points points =
      box_points({1.0, 1.0, 0.0}, {false, false, false, false, true, false}, 1000, 0.0, 6, {});
  Placement half;
  half.centre_T = half.centre_T + half.R_TB * Eigen::Vector3d(0.25, 0.0, 0.0);
  const Points dense =
      box_points({0.5, 1.0, 0.0}, {false, false, false, false, true, false}, 4000, 0.0, 7, half);
  points.insert(points.end(), dense.begin(), dense.end());
  const Placement whole;
  const double before = (centroid_T(points) - whole.centre_T).norm();
  Cloud cloud = cloud_of(points);
  CloudScratch scratch;
  homogenise(0.08, scratch, cloud);
  EXPECT_GT(before, 0.19);  // 4000 of 5000 points are centred 0.25 off
  EXPECT_LT((centroid_T(cloud.points_T.view()) - whole.centre_T).norm(), 0.02);
}

// verifies: SHP-01
TEST(Denoise, LeavesOutStraysAndValuesThatAreNotFinite) {
  Points points = box_points({1.0, 0.8, 0.6}, kAllSides, 1500, 0.003, 8);
  add_strays(points, 150, 3.0, 8);
  points.push_back(Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  points.push_back(Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()));
  CloudScratch scratch;
  Cloud cloud;
  ASSERT_TRUE(denoise(points, {}, scratch, cloud).ok());
  const Placement at;
  std::size_t off = 0;
  for (const Eigen::Vector3d& p : cloud.points_T) {
    ASSERT_TRUE(p.allFinite());
    const Eigen::Vector3d inside =
        (at.R_TB.transpose() * (p - at.centre_T)).cwiseAbs() - Eigen::Vector3d(0.5, 0.4, 0.3);
    off += inside.maxCoeff() > 0.1 ? 1U : 0U;
  }
  EXPECT_EQ(off, 0U);  // 150 strays in 216 cubic units are 0.6 apart on average: no 4 of them
                       // within 4 spacings
}

TEST(Denoise, IsAnErrorWithoutPoints) {
  CloudScratch scratch;
  Cloud cloud;
  EXPECT_EQ(denoise(Points{}, {}, scratch, cloud).error().code, ErrorCode::kTooFewObservations);
}

}  // namespace
}  // namespace polhode::cloud_test
