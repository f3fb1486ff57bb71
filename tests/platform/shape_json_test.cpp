#include "app/shape_json.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "temporary_folder.hpp"

namespace polhode::platform::shape_json_test {
namespace {

nlohmann::json written(const ShapeReport& report) {
  const TemporaryFolder folder;
  write_shape_json(folder.path() / "shape.json", report);
  std::ifstream in(folder.path() / "shape.json");
  return nlohmann::json::parse(in);
}

ScaleState known_scale() {
  ScaleState scale;
  scale.known = true;
  scale.metres_per_mu = 2.0;
  scale.relative_sigma = 0.01;
  const bool taken = add_reading(
      {.source = ScaleSource::kKnownLength, .metres_per_mu = 2.0, .sigma = 0.02}, scale.readings);
  scale.used[0] = taken;
  return scale;
}

TEST(ShapeJson, TellsWhatWasFound_InTheUnitThatIsKnown) {
  Shape shape;
  shape.dimensions = {1.0, 0.5, 0.25};
  shape.frame.source = FrameSource::kPlanes;
  ASSERT_TRUE(shape.planes.push_back(Plane{.offset = 0.5, .inliers = 40}));
  shape.cylinder = Cylinder{.radius = 0.3};
  shape.dimension_basis = {
      DimensionBasis::kSurfaces, DimensionBasis::kPoints, DimensionBasis::kNothing};
  const nlohmann::json json = written({.shape = &shape, .reason = {}, .scale = known_scale()});
  EXPECT_EQ(json["unit"], "m");
  EXPECT_EQ(json["scale"]["source"], "known length");
  EXPECT_EQ(json["scale"]["metres_per_map_unit"], 2.0);
  EXPECT_EQ(json["shape"]["dimensions"], nlohmann::json({1.0, 0.5, 0.25}));
  EXPECT_EQ(json["shape"]["planes"][0]["inliers"], 40);
  EXPECT_EQ(json["shape"]["cylinder"]["radius"], 0.3);
  EXPECT_TRUE(json["shape"]["box"].is_null());
  EXPECT_EQ(json["shape"]["axes"]["z"], nlohmann::json({0.0, 0.0, 1.0}));
  EXPECT_EQ(json["shape"]["dimensions_rest_on"], nlohmann::json({"surfaces", "points", "nothing"}));
  EXPECT_EQ(json["scale"]["contradiction"], false);
}

TEST(ShapeJson, ReportsReadingsThatContradictEachOther) {
  ScaleState scale = known_scale();
  ASSERT_TRUE(add_reading({.source = ScaleSource::kRange, .metres_per_mu = 3.0, .sigma = 0.01},
                          scale.readings));
  scale.known = false;
  scale.contradiction = true;
  scale.used = {};
  const nlohmann::json json = written({.reason = "none", .scale = scale});
  EXPECT_EQ(json["unit"], "map unit");
  EXPECT_EQ(json["scale"]["contradiction"], true);
  EXPECT_EQ(json["scale"]["source"], "none");
  EXPECT_EQ(json["scale"]["readings"][1]["source"], "range");
  EXPECT_EQ(json["scale"]["readings"][1]["metres_per_map_unit"], 3.0);
  EXPECT_EQ(json["unknown"][0], "scale: the readings contradict each other");
}

// verifies: SHP-11
TEST(ShapeJson, NamesWhatCouldNotBeMeasured) {
  const nlohmann::json json =
      written({.reason = "there is no map", .scale_options = {.known_diameter_m = 2.0}});
  EXPECT_EQ(
      json["unknown"],
      nlohmann::json({"scale: nothing in the run could be measured against the known diameter",
                      "metres: lengths are in map units",
                      "shape: there is no map"}));
}

TEST(ShapeJson, IsInTheBodysOwnFrame) {
  Shape shape;
  shape.frame.R_TB.col(0) = Eigen::Vector3d::UnitY();  // the body's x axis is the landmarks' y
  shape.frame.R_TB.col(1) = -Eigen::Vector3d::UnitX();
  shape.centroid_T = {1.0, 2.0, 3.0};
  // A plane through (1, 2.5, 3), half a unit from the centroid along the body's x.
  ASSERT_TRUE(shape.planes.push_back(
      Plane{.normal_T = Eigen::Vector3d::UnitY(), .offset = 2.5, .centre_T = {1.0, 2.5, 3.0}}));
  const nlohmann::json plane = written({.shape = &shape, .reason = {}})["shape"]["planes"][0];
  EXPECT_EQ(plane["normal_T"], nlohmann::json({1.0, 0.0, 0.0}));
  EXPECT_EQ(plane["offset"], 0.5);
  EXPECT_EQ(plane["centre_T"], nlohmann::json({0.5, 0.0, 0.0}));
}

TEST(ShapeJson, WithoutAShape_ReportsWhy) {
  const nlohmann::json json = written({.reason = "the target was never acquired"});
  EXPECT_EQ(json["unit"], "map unit");
  EXPECT_TRUE(json["shape"].is_null());
  EXPECT_TRUE(json["scale"]["metres_per_map_unit"].is_null());
  EXPECT_EQ(json["reason"], "the target was never acquired");
}

}  // namespace
}  // namespace polhode::platform::shape_json_test
