#include "shape/shape.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "surfaces.hpp"

namespace polhode::shape_test {
namespace {

const Eigen::Vector3d kDimensions(1.0, 0.8, 0.6);

bool is_rotation(const Eigen::Matrix3d& R) {
  return (R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < 1e-9 && R.determinant() > 0.0;
}

/// A box with two corners gone: the points of a quarter of three sides.
Points damaged_box(std::uint64_t seed) {
  const Placement at;
  Points points;
  for (const Eigen::Vector3d& p : box_points(kDimensions, kAllSides, 2500, 0.003, seed)) {
    const Eigen::Vector3d p_B = at.R_TB.transpose() * (p - at.centre_T);
    const bool gone = p_B.x() > 0.1 && p_B.y() > -0.1;
    if (!gone) points.push_back(p);
  }
  return points;
}

// verifies: SHP-06
TEST(Shape, OfABoxHasItsCentreAxesAndDimensionsWithinTheirSigmas) {
  const Placement at;
  const auto work = new_work();
  int beyond_two_sigma = 0;
  constexpr int kSeeds = 20;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Result<Shape> result = estimate_shape(
        box_points(kDimensions, kAllSides, 1500, 0.004, seed), {}, 1, nullptr, *work);
    ASSERT_TRUE(result.ok());
    const Shape& shape = result.value();
    EXPECT_EQ(shape.completion, CompletionKind::kBox);
    EXPECT_EQ(shape.frame.source, FrameSource::kPlanes);
    EXPECT_TRUE(is_rotation(shape.frame.R_TB));
    EXPECT_LT((shape.centroid_T - at.centre_T).norm(), 0.002);
    for (Eigen::Index k = 0; k < 3; ++k) {
      Eigen::Index axis = 0;
      const double cosine =
          (at.R_TB.transpose() * shape.frame.R_TB.col(k)).cwiseAbs().maxCoeff(&axis);
      EXPECT_GT(cosine, std::cos(0.3 * 0.01745));
      const double error = std::abs(shape.dimensions(k) - kDimensions(axis));
      EXPECT_LT(error, 0.005);
      beyond_two_sigma += error > 2.0 * shape.sigma_dimensions(k) ? 1 : 0;
    }
  }
  // 60 values, 5 % beyond two sigma expected: 3; 10 would be four standard deviations more.
  EXPECT_LE(beyond_two_sigma, 10);
}

// verifies: SHP-04
TEST(Shape, OfADamagedBoxIsCompletedAndItsCentreTwiceAsGoodAtLeast) {
  const Placement at;
  const auto work = new_work();
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Result<Shape> result = estimate_shape(damaged_box(seed), {}, 1, nullptr, *work);
    ASSERT_TRUE(result.ok());
    const Shape& shape = result.value();
    EXPECT_EQ(shape.completion, CompletionKind::kBox) << seed;
    const double before = (shape.centroid_measured_T - at.centre_T).norm();
    const double after = (shape.centroid_T - at.centre_T).norm();
    EXPECT_LT(after, 0.5 * before) << seed;
    EXPECT_GT(shape.completion_points, 100U);
    EXPECT_EQ(work->cloud.points_T.size(), work->cloud.measured + shape.completion_points);
  }
}

TEST(Shape, CompletionPointsLieOnTheBoxAwayFromMeasuredOnesAtTheirDensity) {
  const Placement at;
  const auto work = new_work();
  const Result<Shape> result = estimate_shape(
      box_points(kDimensions, {true, false, true, false, true, false}, 1200, 0.002, 3),
      {},
      1,
      nullptr,
      *work);
  ASSERT_TRUE(result.ok());
  ASSERT_EQ(result.value().completion, CompletionKind::kBox);
  // Three of six sides are missing: as many points are added as were measured, give or take the
  // rims.
  const auto measured = static_cast<double>(work->cloud.measured);
  EXPECT_NEAR(static_cast<double>(result.value().completion_points), measured, 0.25 * measured);
  for (std::size_t i = work->cloud.measured; i < work->cloud.points_T.size(); ++i) {
    const Eigen::Vector3d p_B = at.R_TB.transpose() * (work->cloud.points_T[i] - at.centre_T);
    EXPECT_NEAR((p_B.cwiseAbs() - 0.5 * kDimensions).maxCoeff(), 0.0, 0.03);
  }
}

// verifies: SHP-05
TEST(Shape, OfACylinderHasItsAxisRadiusAndCentre) {
  const Placement at;
  const auto work = new_work();
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    const Result<Shape> result =
        estimate_shape(cylinder_points(0.4, 1.2, 2.0 * std::numbers::pi, 1800, 0.004, seed),
                       {},
                       1,
                       nullptr,
                       *work);
    ASSERT_TRUE(result.ok());
    const Shape& shape = result.value();
    ASSERT_TRUE(shape.cylinder.has_value());
    EXPECT_EQ(shape.frame.source, FrameSource::kCylinder);
    EXPECT_LT(angle_between_axes(shape.frame.R_TB.col(2), at.R_TB.col(2)), 0.3 * 0.01745);
    EXPECT_NEAR(shape.dimensions.x(), 0.8, 0.004);
    EXPECT_NEAR(shape.dimensions.z(), 1.2, 0.02);
    EXPECT_LT((shape.centroid_T - at.centre_T).norm(), 0.01);
  }
}

TEST(Shape, OfAHalfSeenCylinderHasACentreThatIsMuchBetterThanTheCloudsMean) {
  const Placement at;
  const auto work = new_work();
  const Result<Shape> result = estimate_shape(
      cylinder_points(0.4, 1.2, std::numbers::pi, 1500, 0.003, 4), {}, 1, nullptr, *work);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result.value().completion, CompletionKind::kCylinder);
  EXPECT_GT((result.value().centroid_measured_T - at.centre_T).norm(), 0.1);
  EXPECT_LT((result.value().centroid_T - at.centre_T).norm(), 0.02);
}

TEST(Shape, OfASatelliteWithPanelsIsNotCompletedToABox) {
  Placement panel;
  Points points = box_points({0.5, 0.5, 0.5}, kAllSides, 1200, 0.002, 5);
  for (const double side : {-0.9, 0.9}) {
    Placement at;
    at.centre_T += at.R_TB * Eigen::Vector3d(side, 0.0, 0.0);
    const Points more =
        box_points({1.2, 0.5, 0.0}, {false, false, false, false, true, false}, 700, 0.002, 6, at);
    points.insert(points.end(), more.begin(), more.end());
  }
  const auto work = new_work();
  const Result<Shape> result = estimate_shape(points, {}, 1, nullptr, *work);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result.value().completion, CompletionKind::kNone);
  EXPECT_GE(result.value().planes.size(), 5U);
  EXPECT_EQ(result.value().centroid_T, result.value().centroid_measured_T);
}

TEST(Shape, KeepsItsAxesWhenItIsEstimatedAgain) {
  const auto work = new_work();
  Shape previous =
      estimate_shape(box_points({1.0, 1.0, 1.0}, kAllSides, 1500, 0.004, 0), {}, 1, nullptr, *work)
          .value();
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    // A cube, of which other sides are seen each time: only continuity distinguishes its axes.
    const std::array<bool, 6> sides{seed % 2 == 0, true, true, seed % 3 == 0, seed % 5 != 0, true};
    const Shape next =
        estimate_shape(
            box_points({1.0, 1.0, 1.0}, sides, 1500, 0.004, seed), {}, seed, &previous, *work)
            .value();
    EXPECT_LT(rotation_angle_rad(next.frame.R_TB, previous.frame.R_TB), 0.02) << seed;
    previous = next;
  }
}

TEST(Shape, OfACylinderKeepsItsAxesToo) {
  const auto work = new_work();
  const auto cylinder = [](std::uint64_t seed) {
    return cylinder_points(0.4, 1.2, 2.0 * std::numbers::pi, 1500, 0.004, seed);
  };
  Shape previous = estimate_shape(cylinder(0), {}, 1, nullptr, *work).value();
  for (std::uint64_t seed = 1; seed < 10; ++seed) {
    const Shape next = estimate_shape(cylinder(seed), {}, seed, &previous, *work).value();
    EXPECT_LT(rotation_angle_rad(next.frame.R_TB, previous.frame.R_TB), 0.01) << seed;
    previous = next;
  }
}

// verifies: SHP-07
TEST(Shape, NeverRenamesItsAxesWhateverIsSeenOfIt) {
  // Any sides of any box and any arc of any cylinder, one after the other: the frame turns by what
  // the geometry has changed, never by a quarter or half turn on top. Each next frame is within
  // half of the least relabelling of a box, 90 deg; a cylinder's about its axis is free.
  const auto work = new_work();
  for (std::uint64_t run = 0; run < 4; ++run) {
    Rng rng(run, 40);
    std::optional<Shape> previous;
    const Eigen::Vector3d size(1.0, 0.6 + 0.4 * rng.uniform(), 0.6 + 0.4 * rng.uniform());
    for (std::uint64_t update = 0; update < 8; ++update) {
      std::array<bool, 6> sides{};
      for (bool& side : sides) side = rng.uniform() < 0.7;
      sides[0] = sides[2] = true;  // two orthogonal ones at least
      const bool round = rng.uniform() < 0.3;
      const Points points =
          round ? cylinder_points(0.4, 1.2, 3.0 + 3.0 * rng.uniform(), 900, 0.004, update)
                : box_points(size, sides, 900, 0.004, update);
      const Result<Shape> next =
          estimate_shape(points, {}, update, previous ? &*previous : nullptr, *work);
      ASSERT_TRUE(next.ok());
      EXPECT_TRUE(is_rotation(next.value().frame.R_TB));
      if (previous) {
        // Not above 60 deg, where no relabelling of a cube can be nearer than 63 deg at worst.
        EXPECT_LT(rotation_angle_rad(next.value().frame.R_TB, previous->frame.R_TB), 1.1)
            << run << " " << update;
      }
      previous = next.value();
    }
  }
}

TEST(Shape, ACylinderTakesTheNameOfTheAxisThatItHadAsABox) {
  const auto work = new_work();
  Shape previous;
  previous.frame.R_TB = Placement{}.R_TB * so3_exp({0.0, 0.5 * std::numbers::pi, 0.0});
  const Shape shape =
      estimate_shape(cylinder_points(0.4, 1.2, 2.0 * std::numbers::pi, 1200, 0.004, 3),
                     {},
                     1,
                     &previous,
                     *work)
          .value();
  // B's x lies along the axis now, and the dimensions follow the names.
  EXPECT_LT(rotation_angle_rad(shape.frame.R_TB, previous.frame.R_TB), 0.02);
  EXPECT_NEAR(shape.dimensions.x(), 1.2, 0.02);
  EXPECT_NEAR(shape.dimensions.z(), 0.8, 0.01);
  EXPECT_EQ(shape.frame.axes_known, (std::array<bool, 3>{true, false, false}));
}

TEST(Shape, SaysWhatItsLengthsAndAxesRestOn) {
  const auto work = new_work();
  const auto one = [&](const Points& points) {
    return estimate_shape(points, {}, 1, nullptr, *work).value();
  };
  const Shape box = one(box_points(kDimensions, kAllSides, 1500, 0.004, 1));
  EXPECT_EQ(box.frame.axes_known, (std::array<bool, 3>{true, true, true}));
  for (const DimensionBasis basis : box.dimension_basis) {
    EXPECT_EQ(basis, DimensionBasis::kSurfaces);
  }
  const Shape panel =
      one(box_points({1.0, 0.5, 0.0}, {false, false, false, false, true, false}, 600, 0.002, 8));
  EXPECT_EQ(panel.dimension_basis[0], DimensionBasis::kNothing);  // x is its normal
  EXPECT_EQ(panel.dimension_basis[1], DimensionBasis::kPoints);
  EXPECT_EQ(panel.dimension_basis[2], DimensionBasis::kPoints);
  Points line;
  for (int i = 0; i < 200; ++i) line.push_back(0.01 * i * Eigen::Vector3d(1.0, 2.0, -0.5));
  const Shape rod = one(line);
  EXPECT_EQ(rod.frame.axes_known, (std::array<bool, 3>{true, false, false}));
  EXPECT_EQ(rod.dimension_basis[0], DimensionBasis::kPoints);
  EXPECT_EQ(rod.dimension_basis[1], DimensionBasis::kNothing);
}

TEST(Shape, IsTheSameForTheSameInput) {
  const Points points = damaged_box(7);
  const auto a = new_work();
  const auto b = new_work();
  const Shape one = estimate_shape(points, {}, 3, nullptr, *a).value();
  const Shape two = estimate_shape(points, {}, 3, nullptr, *b).value();
  EXPECT_EQ(one.centroid_T, two.centroid_T);
  EXPECT_EQ(one.frame.R_TB, two.frame.R_TB);
  EXPECT_EQ(one.dimensions, two.dimensions);
  ASSERT_EQ(a->cloud.points_T.size(), b->cloud.points_T.size());
  for (std::size_t i = 0; i < a->cloud.points_T.size(); ++i) {
    EXPECT_EQ(a->cloud.points_T[i], b->cloud.points_T[i]);
  }
}

// verifies: SHP-11
TEST(Shape, OfOnePanelSaysOnlyWhatAPanelTells) {
  const auto work = new_work();
  const Result<Shape> result = estimate_shape(
      box_points({1.0, 0.5, 0.0}, {false, false, false, false, true, false}, 600, 0.002, 8),
      {},
      1,
      nullptr,
      *work);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result.value().planes.size(), 1U);
  EXPECT_EQ(result.value().completion, CompletionKind::kNone);
  EXPECT_FALSE(result.value().box.has_value());
  EXPECT_FALSE(result.value().cylinder.has_value());
  EXPECT_TRUE(is_rotation(result.value().frame.R_TB));
}

TEST(Shape, OfDegenerateCloudsIsAnErrorOrHasNothingMadeUp) {
  const auto work = new_work();
  EXPECT_FALSE(estimate_shape(Points{}, {}, 1, nullptr, *work).ok());
  EXPECT_FALSE(estimate_shape(Points(4, Eigen::Vector3d::Ones()), {}, 1, nullptr, *work).ok());
  EXPECT_FALSE(estimate_shape(Points(100, Eigen::Vector3d::Ones()), {}, 1, nullptr, *work).ok());
  Points line;
  for (int i = 0; i < 200; ++i) line.push_back(0.01 * i * Eigen::Vector3d(1.0, 2.0, -0.5));
  const Result<Shape> result = estimate_shape(line, {}, 1, nullptr, *work);
  ASSERT_TRUE(result.ok());
  EXPECT_TRUE(result.value().planes.empty());
  EXPECT_FALSE(result.value().cylinder.has_value());
  EXPECT_EQ(result.value().completion, CompletionKind::kNone);
  EXPECT_TRUE(is_rotation(result.value().frame.R_TB));
}

TEST(Shape, TakesAtMostTheTablesCapacity) {
  const auto work = new_work();
  const Result<Shape> result = estimate_shape(
      box_points(kDimensions, kAllSides, static_cast<int>(limits::kCloudPoints) + 500, 0.0005, 9),
      {},
      1,
      nullptr,
      *work);
  ASSERT_TRUE(result.ok());
  EXPECT_LE(work->cloud.points_T.size(), limits::kCloudPoints);
}

}  // namespace
}  // namespace polhode::shape_test
