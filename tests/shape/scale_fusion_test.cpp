#include "shape/scale_fusion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "shape/scale_of_shape.hpp"
#include "surfaces.hpp"

namespace polhode::scale_fusion_test {
namespace {

ScaleReadings readings_of(std::initializer_list<ScaleReading> list) {
  ScaleReadings readings;
  for (const ScaleReading& reading : list) EXPECT_TRUE(add_reading(reading, readings));
  return readings;
}

TEST(FuseScales, OfNoReadingIsUnknownAndOfOneIsThatOne) {
  EXPECT_FALSE(fuse_scales({}).known);
  EXPECT_FALSE(fuse_scales({}).contradiction);
  const FusedScale fused = fuse_scales(readings_of({{ScaleSource::kRange, 2.0, 0.04}}));
  EXPECT_TRUE(fused.known);
  EXPECT_DOUBLE_EQ(fused.metres_per_mu, 2.0);
  EXPECT_NEAR(fused.sigma, 0.04, 1e-12);
}

TEST(FuseScales, OfReadingsThatAgreeIsTheirWeightedMean) {
  // Sigmas of 1 % and 2 %: weights 4 to 1, sigma 1 / sqrt(1.25) %.
  const FusedScale fused = fuse_scales(
      readings_of({{ScaleSource::kKnownLength, 1.0, 0.01}, {ScaleSource::kRange, 1.03, 0.0206}}));
  EXPECT_TRUE(fused.known);
  EXPECT_FALSE(fused.contradiction);
  EXPECT_NEAR(std::log(fused.metres_per_mu), 0.2 * std::log(1.03), 1e-12);
  EXPECT_NEAR(fused.sigma / fused.metres_per_mu, 0.01 / std::sqrt(1.25), 1e-9);
}

// verifies: SHP-09
TEST(FuseScales, OfTwoThatContradictIsUnknown_NotTheirMean) {
  const FusedScale fused = fuse_scales(
      readings_of({{ScaleSource::kKnownLength, 1.0, 0.01}, {ScaleSource::kRange, 1.1, 0.01}}));
  EXPECT_FALSE(fused.known);
  EXPECT_TRUE(fused.contradiction);
}

TEST(FuseScales, OfThreeOfWhichTwoAgreeIsTheirs_AndTheThirdIsReported) {
  const FusedScale fused = fuse_scales(readings_of({{ScaleSource::kKnownLength, 1.0, 0.01},
                                                    {ScaleSource::kRange, 1.3, 0.001},
                                                    {ScaleSource::kDiameter, 1.01, 0.01}}));
  EXPECT_TRUE(fused.known);
  EXPECT_TRUE(fused.contradiction);
  EXPECT_NEAR(fused.metres_per_mu, 1.005, 0.001);
  EXPECT_TRUE(fused.used[0]);
  EXPECT_FALSE(fused.used[1]);
  EXPECT_TRUE(fused.used[2]);
}

TEST(FuseScales, OfTwoPairsThatContradictIsUnknown) {
  EXPECT_FALSE(fuse_scales(readings_of({{ScaleSource::kKnownLength, 1.0, 0.01},
                                        {ScaleSource::kRange, 1.01, 0.01},
                                        {ScaleSource::kDiameter, 2.0, 0.01},
                                        {ScaleSource::kEdge, 2.01, 0.01}}))
                   .known);
}

TEST(FuseScales, DoesNotDependOnTheUnit) {
  const FusedScale one = fuse_scales(
      readings_of({{ScaleSource::kKnownLength, 1.0, 0.01}, {ScaleSource::kRange, 1.02, 0.02}}));
  const FusedScale thousand = fuse_scales(readings_of(
      {{ScaleSource::kKnownLength, 1000.0, 10.0}, {ScaleSource::kRange, 1020.0, 20.0}}));
  EXPECT_NEAR(thousand.metres_per_mu, 1000.0 * one.metres_per_mu, 1e-9);
}

TEST(TakeReading, LeavesOutWhatIsNoReadingAndReplacesAnEarlierOne) {
  ScaleReadings readings;
  const double nan = std::nan("");
  EXPECT_FALSE(add_reading({ScaleSource::kNone, 1.0, 0.1}, readings));
  EXPECT_FALSE(add_reading({ScaleSource::kRange, 0.0, 0.1}, readings));
  EXPECT_FALSE(add_reading({ScaleSource::kRange, -1.0, 0.1}, readings));
  EXPECT_FALSE(add_reading({ScaleSource::kRange, nan, 0.1}, readings));
  EXPECT_FALSE(add_reading({ScaleSource::kRange, 1.0, 0.0}, readings));
  EXPECT_FALSE(add_reading({ScaleSource::kRange, 1.0, nan}, readings));
  EXPECT_TRUE(readings.empty());
  EXPECT_TRUE(add_reading({ScaleSource::kRange, 1.0, 0.1}, readings));
  EXPECT_TRUE(add_reading({ScaleSource::kRange, 2.0, 0.1}, readings));
  ASSERT_EQ(readings.size(), 1U);
  EXPECT_EQ(readings[0].metres_per_mu, 2.0);
}

Shape shape_of(const Points& points) {
  const auto work = new_work();
  return estimate_shape(points, {}, 1, nullptr, *work).value();
}

TEST(ScaleOfShape, FromADiameterIsWithinItsSigma) {
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    // A radius of 0.4 map units that is 1.6 m in truth: 4 m per map unit.
    const Shape shape =
        shape_of(cylinder_points(0.4, 1.2, 2.0 * std::numbers::pi, 1800, 0.004, seed));
    const Result<ScaleEstimate> scale = scale_from_diameter(shape, 3.2);
    ASSERT_TRUE(scale.ok());
    EXPECT_NEAR(scale.value().metres_per_mu, 4.0, 3.0 * scale.value().sigma);
    EXPECT_LT(scale.value().sigma, 0.02 * 4.0);
  }
}

TEST(ScaleOfShape, FromAnEdgeTakesTheLongest_OrTheOneThatFitsAnotherReading) {
  const Shape shape = shape_of(box_points({1.0, 0.8, 0.6}, kAllSides, 1800, 0.004, 2));
  const Result<ScaleEstimate> longest = scale_from_edge(shape, 2.0, std::nullopt);
  ASSERT_TRUE(longest.ok());
  EXPECT_NEAR(longest.value().metres_per_mu, 2.0, 3.0 * longest.value().sigma);
  // 1.2 m are the shortest edge at about 2 m per map unit.
  const Result<ScaleEstimate> matched = scale_from_edge(shape, 1.2, 2.1);
  ASSERT_TRUE(matched.ok());
  EXPECT_NEAR(matched.value().metres_per_mu, 2.0, 3.0 * matched.value().sigma);
}

TEST(ScaleOfShape, FromAnEdgeGivesNothing_WhereTheLongestMayHaveEndsThatWereNotFound) {
  Shape shape = shape_of(box_points({1.0, 0.8, 0.6}, kAllSides, 1800, 0.004, 2));
  Eigen::Index longest = 0;
  (void)shape.dimensions.maxCoeff(&longest);
  shape.dimension_basis[static_cast<std::size_t>(longest)] = DimensionBasis::kPoints;
  EXPECT_EQ(scale_from_edge(shape, 2.0, std::nullopt).error().code, ErrorCode::kDegenerate);
  EXPECT_TRUE(scale_from_edge(shape, 1.6, 2.1).ok()) << "another reading tells which edge it is";
}

TEST(ScaleOfShape, IsAnErrorWhereTheShapeHasNoSuchThing) {
  const Shape box = shape_of(box_points({1.0, 0.8, 0.6}, kAllSides, 1500, 0.004, 3));
  EXPECT_EQ(scale_from_diameter(box, 1.0).error().code, ErrorCode::kNoConsensus);
  EXPECT_EQ(scale_from_diameter(box, 0.0).error().code, ErrorCode::kBadParameter);
  EXPECT_EQ(scale_from_edge(box, -1.0, std::nullopt).error().code, ErrorCode::kBadParameter);
  EXPECT_EQ(scale_from_edge(Shape{}, 1.0, std::nullopt).error().code, ErrorCode::kNoConsensus);
}

}  // namespace
}  // namespace polhode::scale_fusion_test
