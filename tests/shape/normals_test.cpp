#include "shape/normals.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "surfaces.hpp"

namespace polhode::normals_test {
namespace {

struct Estimated {
  SurfaceNormals normals;
  double thickness = 0.0;
};

std::unique_ptr<Estimated> estimate(const Points& points, double radius) {
  auto out = std::make_unique<Estimated>();
  const auto scratch = std::make_unique<CloudScratch>();
  out->thickness = estimate_normals(points, radius, *scratch, out->normals);
  return out;
}

std::unique_ptr<Estimated> estimate_by_spacing(const Points& points, double spacing) {
  auto out = std::make_unique<Estimated>();
  const auto scratch = std::make_unique<CloudScratch>();
  out->thickness = estimate_normals_by_spacing(points, spacing, *scratch, out->normals);
  return out;
}

/// A unit square in a plane through the origin.
Points sheet(const Eigen::Matrix3d& R, double sigma, std::uint64_t seed) {
  Rng rng(seed, 8);
  Points points;
  for (int i = 0; i < 2000; ++i) {
    points.push_back(
        R * Eigen::Vector3d(rng.uniform() - 0.5, rng.uniform() - 0.5, sigma * rng.normal()));
  }
  return points;
}

constexpr double kSpacing = 0.011;  // to the nearest neighbour: half of 1 / sqrt(2000)

TEST(Normals, OfASheetAreItsOwn) {
  const Eigen::Matrix3d R = so3_exp({0.3, -0.5, 0.8});
  const auto found = estimate(sheet(R, 0.0, 1), 0.07);  // some 30 neighbours
  ASSERT_EQ(found->normals.size(), 2000U);
  for (const SurfaceNormal& normal : found->normals) {
    EXPECT_TRUE(normal.reliable);
    EXPECT_NEAR(normal.normal_T.norm(), 1.0, 1e-9);
    EXPECT_LT(angle_between_axes(normal.normal_T, R.col(2)), 1e-6);
  }
  EXPECT_LT(found->thickness, 1e-9);
}

TEST(Normals, TellTheNoiseAcrossTheSurface) {
  for (const double sigma : {0.002, 0.005}) {
    const auto found = estimate_by_spacing(sheet(Eigen::Matrix3d::Identity(), sigma, 2), kSpacing);
    EXPECT_NEAR(found->thickness / sigma, 1.0, 0.2) << sigma;
  }
}

TEST(Normals, LookFartherAroundWhereTheNoiseIsLarge) {
  constexpr double kSigma = 0.015;  // within three spacings the cloud is then a ball
  const Points points = sheet(Eigen::Matrix3d::Identity(), kSigma, 3);
  const auto count_right = [](const Estimated& found) {
    int right = 0;
    for (const SurfaceNormal& normal : found.normals) {
      right += normal.reliable && std::abs(normal.normal_T.z()) > 0.9 ? 1 : 0;
    }
    return right;
  };
  const int near = count_right(*estimate(points, 3.0 * kSpacing));
  const int farther = count_right(*estimate_by_spacing(points, kSpacing));
  EXPECT_GT(farther, 500);
  EXPECT_GT(farther, 4 * near);
}

TEST(Normals, AreNotReliableAtAnEdge) {
  const Placement at{.R_TB = Eigen::Matrix3d::Identity(), .centre_T = Eigen::Vector3d::Zero()};
  const Points points = box_points({1.0, 1.0, 1.0}, kAllSides, 6000, 0.0, 4, at);
  const auto found = estimate(points, 0.1);
  int at_edges = 0;
  int reliable_at_edges = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Distances from the three pairs of sides, the nearest first.
    Eigen::Vector3d inside = (0.5 - points[i].cwiseAbs().array()).matrix();
    std::sort(inside.data(), inside.data() + 3);
    if (inside(1) > 0.1) {
      EXPECT_TRUE(found->normals[i].reliable) << i;
    }
    if (inside(1) < 0.01) {
      ++at_edges;
      reliable_at_edges += found->normals[i].reliable ? 1 : 0;
    }
  }
  EXPECT_GT(at_edges, 100);
  EXPECT_LT(reliable_at_edges, at_edges / 20);
}

TEST(Normals, OfTooFewNeighboursAreNotReliable) {
  const Points apart{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {1.0, 1.0, 0.0}};
  const auto found = estimate(apart, 0.1);
  ASSERT_EQ(found->normals.size(), 4U);
  for (const SurfaceNormal& normal : found->normals) EXPECT_FALSE(normal.reliable);
  EXPECT_EQ(found->thickness, 0.0);
  EXPECT_TRUE(estimate({}, 0.1)->normals.empty());
}

}  // namespace
}  // namespace polhode::normals_test
