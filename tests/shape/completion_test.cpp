#include "shape/completion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numbers>

#include "surfaces.hpp"

namespace polhode::completion_test {
namespace {

const Placement kAtOrigin{.R_TB = Eigen::Matrix3d::Identity(), .centre_T = Eigen::Vector3d::Zero()};
const Eigen::Vector3d kSize(1.0, 0.8, 0.6);

std::unique_ptr<Cloud> cloud_of(const Points& points) {
  auto cloud = std::make_unique<Cloud>();
  for (const Eigen::Vector3d& point : points) EXPECT_TRUE(cloud->points_T.push_back(point));
  cloud->measured = cloud->points_T.size();
  return cloud;
}

/// A face of the box about the origin: `axis` 0 .. 2, `sign` its side.
Plane face(Eigen::Index axis, double sign, std::size_t inliers) {
  Plane plane;
  plane.normal_T = sign * Eigen::Vector3d::Unit(axis);
  plane.offset = 0.5 * kSize(axis);
  plane.centre_T = 0.5 * kSize(axis) * plane.normal_T;
  plane.axes_T.col(0) = Eigen::Vector3d::Unit((axis + 1) % 3);
  plane.axes_T.col(1) = Eigen::Vector3d::Unit((axis + 2) % 3);
  plane.extents = {1.0, 0.5};
  plane.inliers = inliers;
  plane.covariance(2, 2) = 1e-6;
  return plane;
}

Planes faces(const std::vector<Plane>& list) {
  Planes planes;
  for (const Plane& plane : list) EXPECT_TRUE(planes.push_back(plane));
  return planes;
}

TEST(FindBox, TakesSidesFromPlanes_AndFromThePointsEndWhereThereIsNone) {
  const auto cloud = cloud_of(box_points(kSize, kAllSides, 3000, 0.0, 1, kAtOrigin));
  const auto found = find_box(
      *cloud, faces({face(0, 1.0, 300), face(1, -1.0, 200), face(1, 1.0, 150)}), 0.02, 0.03);
  ASSERT_TRUE(found.ok());
  const Box& box = found.value();
  EXPECT_EQ(box.face_found, (std::array{false, true, true, true, false, false}));
  // Where no plane is, an end lies 2 % out: it is that of points spread evenly along the axis.
  EXPECT_NEAR(box.dimensions(0), 1.02, 0.005);
  EXPECT_NEAR(box.dimensions(1), 0.8, 1e-9);  // both ends by planes
  EXPECT_NEAR(box.dimensions(2), 1.042 * 0.6, 0.005);
  EXPECT_LT(box.centre_T.norm(), 0.02);
  // A plane's own sigma against half a spacing.
  EXPECT_NEAR(box.sigma_dimensions(1), std::sqrt(2e-6), 1e-5);
  EXPECT_NEAR(box.sigma_dimensions(2), std::hypot(0.01, 0.01), 1e-9);
  EXPECT_GT(box.explained, 0.95);
}

TEST(FindBox, OfSeveralPlanesAtAnEndTakesTheOneWithMostPoints_AndNoneFromTheMiddle) {
  const auto cloud = cloud_of(box_points(kSize, kAllSides, 3000, 0.0, 1, kAtOrigin));
  Plane ledge = face(0, 1.0, 50);
  ledge.centre_T.x() -= 0.05;
  Plane bulkhead = face(0, 1.0, 900);
  bulkhead.centre_T.x() = 0.1;
  const auto found =
      find_box(*cloud, faces({bulkhead, face(0, 1.0, 300), ledge, face(1, 1.0, 200)}), 0.02, 0.03);
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(found.value().face_found[1]);
  const double right = found.value().centre_T.x() + 0.5 * found.value().dimensions(0);
  EXPECT_NEAR(right, 0.5, 1e-9);
}

TEST(FindBox, NeedsTwoOrthogonalPlanes) {
  const auto cloud = cloud_of(box_points(kSize, kAllSides, 500, 0.0, 1, kAtOrigin));
  const auto code = [&](const Planes& planes) {
    return find_box(*cloud, planes, 0.05, 0.02).error().code;
  };
  EXPECT_EQ(code({}), ErrorCode::kDegenerate);
  EXPECT_EQ(code(faces({face(0, 1.0, 100)})), ErrorCode::kDegenerate);
  EXPECT_EQ(code(faces({face(0, 1.0, 100), face(0, -1.0, 90)})), ErrorCode::kDegenerate);
}

TEST(FindBox, RefusesWhatIsNoBoxOrHasNoDepth) {
  // A ball: two made-up planes, and most points off the box.
  Rng rng(2, 2);
  Points ball;
  for (int i = 0; i < 2000; ++i) ball.push_back(0.5 * noise(rng, 1.0).normalized());
  const Planes planes = faces({face(0, 1.0, 100), face(1, 1.0, 90)});
  EXPECT_EQ(find_box(*cloud_of(ball), planes, 0.02, 0.01).error().code, ErrorCode::kNoConsensus);
  // One thin sheet, and another across it that the points do not bear out.
  const Points sheet =
      box_points(kSize, {false, true, false, false, false, false}, 1000, 0.0, 3, kAtOrigin);
  EXPECT_EQ(find_box(*cloud_of(sheet), planes, 0.02, 0.01).error().code, ErrorCode::kNoConsensus);
}

TEST(CompleteBox, FillsTheMissingSides_EvenlyAndOnTheSurface) {
  // Three of six sides are measured.
  const Points seen =
      box_points(kSize, {true, false, false, true, false, true}, 3000, 0.0, 4, kAtOrigin);
  auto cloud = cloud_of(seen);
  const Box box{.centre_T = Eigen::Vector3d::Zero(), .dimensions = kSize};
  const double area = kSize(0) * kSize(1) + kSize(1) * kSize(2) + kSize(0) * kSize(2);
  const double pitch = std::sqrt(area / 3000.0);
  const std::size_t added = complete_box(box, pitch, *cloud);
  EXPECT_EQ(cloud->points_T.size(), seen.size() + added);
  EXPECT_EQ(cloud->measured, seen.size());
  // As many as were measured on the equal half, less the strips along their edges.
  EXPECT_NEAR(static_cast<double>(added), 3000.0, 300.0);
  int on_measured_sides = 0;
  for (std::size_t i = cloud->measured; i < cloud->points_T.size(); ++i) {
    const Eigen::Vector3d beyond = cloud->points_T[i].cwiseAbs() - 0.5 * kSize;
    EXPECT_NEAR(beyond.maxCoeff(), 0.0, 1e-12);
    const Eigen::Vector3d towards_measured(-1.0, 1.0, 1.0);
    const Eigen::Vector3d off = cloud->points_T[i].cwiseProduct(towards_measured) - 0.5 * kSize;
    on_measured_sides += off.maxCoeff() > -1e-9 ? 1 : 0;
  }
  // Holes by chance are 1 % of the places.
  EXPECT_LT(on_measured_sides, 90);
  // Again: what was added before is taken out first.
  EXPECT_EQ(complete_box(box, pitch, *cloud), added);
}

TEST(CompleteBox, EndsWithTheTable) {
  auto cloud = cloud_of({Eigen::Vector3d::Zero()});
  const Box box{.centre_T = Eigen::Vector3d::Zero(), .dimensions = kSize};
  const std::size_t added = complete_box(box, 1e-3, *cloud);
  EXPECT_EQ(added, limits::kCloudPoints - 1);
  EXPECT_TRUE(cloud->points_T.full());
}

Cylinder round_body() {
  Cylinder cylinder;
  cylinder.radius = 0.4;
  cylinder.length = 1.2;
  cylinder.ends_found = 2;
  return cylinder;
}

TEST(CompleteCylinder, FillsRoundAndEnds_AndAddsNothingToAWholeOne) {
  const Points whole = cylinder_points(0.4, 1.2, 2.0 * std::numbers::pi, 6000, 0.0, 5, kAtOrigin);
  const double area = 2.0 * std::numbers::pi * 0.4 * (1.2 + 0.4);
  const double pitch = std::sqrt(area / 6000.0);
  auto complete = cloud_of(whole);
  EXPECT_LT(complete_cylinder(round_body(), pitch, *complete), 180U);  // 3 %
  auto nothing = cloud_of({Eigen::Vector3d::Zero()});
  const std::size_t added = complete_cylinder(round_body(), pitch, *nothing);
  EXPECT_NEAR(static_cast<double>(added), 6000.0, 300.0);
  for (std::size_t i = 1; i < nothing->points_T.size(); ++i) {
    const Eigen::Vector3d& p = nothing->points_T[i];
    const double radius = p.head<2>().norm();
    EXPECT_TRUE(std::abs(radius - 0.4) < 1e-9 || std::abs(std::abs(p.z()) - 0.6) < 1e-9) << i;
    EXPECT_LT(radius, 0.4 + 1e-9);
    EXPECT_LT(std::abs(p.z()), 0.6 + 1e-9);
  }
}

TEST(CompleteCylinder, DrawsNoEndThatNoFaceSupports) {
  Cylinder open = round_body();
  open.ends_found = 0;
  auto cloud = cloud_of({Eigen::Vector3d::Zero()});
  ASSERT_GT(complete_cylinder(open, 0.02, *cloud), 1000U);
  for (std::size_t i = 1; i < cloud->points_T.size(); ++i) {
    EXPECT_NEAR(cloud->points_T[i].head<2>().norm(), 0.4, 1e-9) << i;
  }
}

TEST(CompleteCylinder, EndsWithTheTable) {
  auto cloud = cloud_of({Eigen::Vector3d::Zero()});
  EXPECT_EQ(complete_cylinder(round_body(), 1e-3, *cloud), limits::kCloudPoints - 1);
}

Plane end_plane(double height, double tilt_rad = 0.0) {
  Plane plane;
  plane.normal_T = so3_exp({tilt_rad, 0.0, 0.0}) * Eigen::Vector3d::UnitZ();
  plane.centre_T = {0.0, 0.0, height};
  return plane;
}

TEST(SnapEnds, MovesEachEndToTheFlatOneNearIt) {
  Cylinder cylinder = round_body();
  EXPECT_EQ(snap_ends(faces({end_plane(0.55), end_plane(-0.58)}), cylinder), 2);
  EXPECT_NEAR(cylinder.length, 1.13, 1e-12);
  EXPECT_NEAR(cylinder.centre_T.z(), -0.015, 1e-12);
}

TEST(SnapEnds, LeavesAnEndWithoutAFlatOne_AndGivesTheFirstPlaneTheLastWord) {
  Cylinder cylinder = round_body();
  // Too far in, not across the axis, and two near the upper end.
  EXPECT_EQ(
      snap_ends(faces({end_plane(0.57), end_plane(0.5), end_plane(-0.3), end_plane(-0.6, 0.5)}),
                cylinder),
      1);
  EXPECT_NEAR(cylinder.centre_T.z() + 0.5 * cylinder.length, 0.57, 1e-12);
  EXPECT_NEAR(cylinder.centre_T.z() - 0.5 * cylinder.length, -0.6, 1e-12);
  Cylinder alone = round_body();
  EXPECT_EQ(snap_ends({}, alone), 0);
  EXPECT_EQ(alone.length, 1.2);
}

TEST(ExplainedBy, CountsRoundAndEndsWithinTheTolerance) {
  const Points points{{0.4, 0.0, 0.3},     // on the round
                      {0.0, -0.41, -0.6},  // near its rim
                      {0.1, 0.1, 0.6},     // on an end
                      {0.1, 0.1, 0.0},     // inside
                      {0.4, 0.0, 0.7},     // beyond the end
                      {0.5, 0.0, 0.6},     // beside it
                      {0.0, 0.4, 0.0}};
  EXPECT_NEAR(explained_by(round_body(), *cloud_of(points), 0.02), 4.0 / 7.0, 1e-12);
  EXPECT_EQ(explained_by(round_body(), Cloud{}, 0.02), 0.0);
  // Points that were added do not count.
  auto cloud = cloud_of(points);
  cloud->measured = 4;
  EXPECT_EQ(explained_by(round_body(), *cloud, 0.02), 0.75);
}

}  // namespace
}  // namespace polhode::completion_test
