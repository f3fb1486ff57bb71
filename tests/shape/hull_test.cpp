#include "shape/hull.hpp"

#include <gtest/gtest.h>

#include <map>

#include "surfaces.hpp"

namespace polhode::hull_test {
namespace {

Result<Hull> hull_of(const Points& points, double tolerance) {
  const auto work = std::make_unique<HullWork>();
  return convex_hull(points, tolerance, *work);
}

/// Every edge belongs to two faces that run along it in opposite directions.
bool is_closed(const Hull& hull) {
  std::map<std::pair<int, int>, int> edges;
  for (const Hull::Face& face : hull.faces) {
    for (std::size_t k = 0; k < 3; ++k) ++edges[{face[k], face[(k + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    if (count != 1 || edges.count({edge.second, edge.first}) != 1) return false;
  }
  return true;
}

/// How far the outermost point lies outside any face.
double farthest_outside(const Points& points, const Hull& hull) {
  double most = 0.0;
  for (const Hull::Face& face : hull.faces) {
    const Eigen::Vector3d a = hull.vertices_T[face[0]];
    const Eigen::Vector3d normal =
        (hull.vertices_T[face[1]] - a).cross(hull.vertices_T[face[2]] - a);
    if (normal.norm() < 1e-12) continue;  // corners on a line
    for (const Eigen::Vector3d& p : points) most = std::max(most, normal.normalized().dot(p - a));
  }
  return most;
}

TEST(Hull, OfABoxIsItsEightCornersAndTwelveTriangles) {
  const Placement at;
  Points points;
  for (const double x : {-0.5, 0.0, 0.5}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      for (const double z : {-1.5, 0.0, 1.5}) points.push_back(at.place({x, y, z}));
    }
  }
  const Result<Hull> hull = hull_of(points, 1e-6);
  ASSERT_TRUE(hull.ok());
  EXPECT_EQ(hull.value().vertices_T.size(), 8U);
  EXPECT_EQ(hull.value().faces.size(), 12U);
  EXPECT_NEAR(hull.value().volume, 1.0 * 2.0 * 3.0, 1e-9);
  EXPECT_NEAR(hull.value().area, 2.0 * (2.0 + 3.0 + 6.0), 1e-9);
  EXPECT_TRUE(is_closed(hull.value()));
}

TEST(Hull, HoldsAllPointsWithinTheTolerance) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed, 7);
    Points points;
    for (int i = 0; i < 400; ++i) points.push_back(noise(rng, 1.0));
    const Result<Hull> hull = hull_of(points, 1e-9);
    ASSERT_TRUE(hull.ok());
    EXPECT_TRUE(is_closed(hull.value())) << seed;
    EXPECT_LE(farthest_outside(points, hull.value()), 1e-8) << seed;
    EXPECT_LE(hull.value().outside, 1e-9);
  }
}

TEST(Hull, OfACompletedGridDoesNotTear) {
  // Sides filled by a grid hold many points on each plane and each line: the worst case for
  // rounding.
  const Placement at;
  for (const double tolerance : {1e-9, 1e-3, 0.05}) {
    Points points;
    for (int i = 0; i <= 20; ++i) {
      for (int j = 0; j <= 20; ++j) {
        for (const double side : {-0.5, 0.5}) {
          points.push_back(at.place({side, i / 20.0 - 0.5, j / 20.0 - 0.5}));
          points.push_back(at.place({i / 20.0 - 0.5, side, j / 20.0 - 0.5}));
          points.push_back(at.place({i / 20.0 - 0.5, j / 20.0 - 0.5, side}));
        }
      }
    }
    const Result<Hull> hull = hull_of(points, tolerance);
    ASSERT_TRUE(hull.ok()) << tolerance;
    EXPECT_TRUE(is_closed(hull.value()));
    EXPECT_NEAR(hull.value().volume, 1.0, 1e-6 + 3.0 * tolerance);
    EXPECT_LE(farthest_outside(points, hull.value()), tolerance + 1e-9);
  }
}

TEST(Hull, OfMoreCornersThanTheTableHoldsLeavesOutTheLeast) {
  Rng rng(3, 0);
  Points points;
  for (int i = 0; i < 5000; ++i) points.push_back(noise(rng, 1.0).normalized());
  const Result<Hull> hull = hull_of(points, 1e-9);
  ASSERT_TRUE(hull.ok());
  EXPECT_LE(hull.value().vertices_T.size(), Hull::kVertices);
  EXPECT_TRUE(is_closed(hull.value()));
  // A ball of 500 corners: caps of 4 pi / 1000 each are 0.2 % high, the largest a few times that.
  EXPECT_GT(hull.value().outside, 0.0);
  EXPECT_LT(hull.value().outside, 0.02);
  EXPECT_NEAR(hull.value().volume, 4.0 / 3.0 * std::numbers::pi, 0.06);
}

TEST(Hull, IsTheSameForTheSamePoints) {
  const Points points = box_points({1.0, 0.8, 0.6}, kAllSides, 1500, 0.004, 5);
  const Hull one = hull_of(points, 0.01).value();
  const Hull two = hull_of(points, 0.01).value();
  ASSERT_EQ(one.faces.size(), two.faces.size());
  for (std::size_t i = 0; i < one.faces.size(); ++i) EXPECT_EQ(one.faces[i], two.faces[i]);
  EXPECT_EQ(one.volume, two.volume);
}

TEST(Hull, OfPointsThatEncloseNothingIsAnError) {
  EXPECT_EQ(hull_of({}, 0.01).error().code, ErrorCode::kTooFewObservations);
  EXPECT_EQ(hull_of(Points(3, Eigen::Vector3d::Ones()), 0.01).error().code,
            ErrorCode::kTooFewObservations);
  EXPECT_EQ(hull_of(Points(50, Eigen::Vector3d::Ones()), 0.01).error().code,
            ErrorCode::kDegenerate);
  Points line;
  Points panel;
  for (int i = 0; i < 50; ++i) {
    line.push_back(i * Eigen::Vector3d(0.1, 0.2, -0.1));
    panel.push_back(Eigen::Vector3d(0.1 * (i % 7), 0.1 * (i / 7), 0.0));
  }
  EXPECT_EQ(hull_of(line, 0.01).error().code, ErrorCode::kDegenerate);
  EXPECT_EQ(hull_of(panel, 0.01).error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace polhode::hull_test
