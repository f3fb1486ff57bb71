#include "shape/rounded.hpp"

#include <gtest/gtest.h>

#include "surfaces.hpp"

namespace polhode::rounded_test {
namespace {

/// Evenly over the directions, at `radius(direction)` from the middle.
template <typename Radius>
Points star(int count, double sigma, std::uint64_t seed, Radius radius, const Placement& at = {}) {
  Rng rng(seed, 4);
  Points points;
  while (points.size() < static_cast<std::size_t>(count)) {
    const Eigen::Vector3d n =
        Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized();
    points.push_back(at.place(radius(n) * n) + noise(rng, sigma));
  }
  return points;
}

Points sphere(int count, double sigma, std::uint64_t seed) {
  return star(count, sigma, seed, [](const Eigen::Vector3d&) { return 1.0; });
}

/// A body of rolling ground, half again as long as wide: a comet's or a rock's.
Points potato(int count, double sigma, std::uint64_t seed) {
  return star(count, sigma, seed, [](const Eigen::Vector3d& n) {
    const double ellipsoid = 1.0 / (n.cwiseQuotient(Eigen::Vector3d(1.5, 1.1, 1.0))).norm();
    return ellipsoid * (1.0 + 0.04 * std::sin(4.0 * n.x() + 1.0) * std::cos(5.0 * n.y()));
  });
}

Shape shape_of(const Points& points, ShapeWork& work) {
  const Result<Shape> result = estimate_shape(points, {}, 1, nullptr, work);
  EXPECT_TRUE(result.ok());
  return result.value();
}

TEST(Rounded, AnEllipsoidIsFittedToItsOwnPoints) {
  const Placement at;
  const Points points = star(
      800,
      0.002,
      3,
      [](const Eigen::Vector3d& n) {
        return 1.0 / (n.cwiseQuotient(Eigen::Vector3d(2.0, 1.2, 1.0))).norm();
      },
      at);
  const Result<Ellipsoid> found = fit_ellipsoid(points, 0.02);
  ASSERT_TRUE(found.ok());
  EXPECT_LT((found.value().centre_T - at.centre_T).norm(), 0.005);
  EXPECT_NEAR(found.value().distance(at.place({2.1, 0.0, 0.0})), 0.1, 0.02);
  EXPECT_NEAR(found.value().distance(at.place({0.0, 0.0, 0.95})), -0.05, 0.01);
}

TEST(Rounded, TooFewPointsOrAFlatOneAreErrors) {
  EXPECT_FALSE(fit_ellipsoid(sphere(19, 0.0, 1), 0.01).ok());
  EXPECT_FALSE(
      fit_ellipsoid(cylinder_points(0.2, 4.0, 6.2, 500, 0.001, 1), 0.01).ok());  // too long
}

TEST(Rounded, ASphereIsNoCylinder_AndNothingIsAddedToIt) {
  const auto work = new_work();
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    for (const double sigma : {0.005, 0.02, 0.04}) {
      const Shape shape = shape_of(sphere(900, sigma, seed), *work);
      EXPECT_FALSE(shape.cylinder.has_value()) << seed << ' ' << sigma;
      EXPECT_EQ(shape.completion, CompletionKind::kNone) << seed << ' ' << sigma;
      EXPECT_EQ(shape.completion_points, 0U);
      for (Eigen::Index k = 0; k < 3; ++k) {
        EXPECT_NEAR(shape.dimensions(k), 2.0, 0.12) << seed << ' ' << sigma;
        EXPECT_EQ(shape.dimension_basis[static_cast<std::size_t>(k)], DimensionBasis::kPoints);
      }
    }
  }
}

TEST(Rounded, APotatoIsNeither) {
  const auto work = new_work();
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Shape shape = shape_of(potato(900, 0.01, seed), *work);
    EXPECT_FALSE(shape.cylinder.has_value()) << seed;
    EXPECT_EQ(shape.completion, CompletionKind::kNone) << seed;
  }
}

TEST(Rounded, ACylinderStaysOne_WholeHalfSeenShortAndWithoutEnds) {
  const auto work = new_work();
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    for (const double arc : {6.283, 3.1416}) {
      for (const double length : {0.7, 1.2, 2.5}) {
        const Shape shape = shape_of(cylinder_points(0.4, length, arc, 1200, 0.006, seed), *work);
        EXPECT_TRUE(shape.cylinder.has_value()) << seed << ' ' << arc << ' ' << length;
      }
    }
  }
}

TEST(Rounded, ABoxStaysABox) {
  const auto work = new_work();
  const Shape shape = shape_of(box_points({1.0, 0.8, 1.3}, kAllSides, 1200, 0.004, 2), *work);
  EXPECT_FALSE(shape.cylinder.has_value());
  EXPECT_EQ(shape.completion, CompletionKind::kBox);
}

}  // namespace
}  // namespace polhode::rounded_test
