#include "shape/target_frame.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <vector>

#include "geometry/so3.hpp"

namespace polhode::target_frame_test {
namespace {

const Eigen::Vector3d kX = Eigen::Vector3d::UnitX();
const Eigen::Vector3d kY = Eigen::Vector3d::UnitY();
const Eigen::Vector3d kZ = Eigen::Vector3d::UnitZ();

Plane plane(const Eigen::Vector3d& normal_T, std::size_t inliers) {
  Plane out;
  out.normal_T = normal_T.normalized();
  out.axes_T.col(0) = normal_T.unitOrthogonal();
  out.axes_T.col(1) = out.normal_T.cross(out.axes_T.col(0));
  out.extents = {1.0, 1.0};
  out.inliers = inliers;
  return out;
}

Planes planes_of(const std::vector<Plane>& list) {
  Planes planes;
  for (const Plane& one : list) EXPECT_TRUE(planes.push_back(one));
  return planes;
}

void expect_right_handed(const Eigen::Matrix3d& R) {
  EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
}

TEST(FrameFromPlanes, TakesXFromTheStrongestAndYFromTheNextAcrossIt) {
  const TargetFrame frame =
      frame_from_planes(planes_of({plane(kZ, 100), plane(-kZ, 80), plane(kX, 60)}));
  EXPECT_LT((frame.R_TB.col(0) - kZ).norm(), 1e-12);
  EXPECT_LT((frame.R_TB.col(1) - kX).norm(), 1e-12);
  EXPECT_EQ(frame.source, FrameSource::kPlanes);
  EXPECT_EQ(frame.axes_known, (std::array{true, true, true}));
  expect_right_handed(frame.R_TB);
}

TEST(FrameFromPlanes, WeighsParallelPlanesByTheirPoints_WhicheverWayTheyFace) {
  // 3 deg to either side, three points against one.
  const Eigen::Vector3d a = so3_exp({0.0, 0.05, 0.0}) * kX;
  const Eigen::Vector3d b = so3_exp({0.0, -0.05, 0.0}) * kX;
  const TargetFrame frame =
      frame_from_planes(planes_of({plane(a, 300), plane(-b, 100), plane(kY, 50)}));
  EXPECT_NEAR(frame.R_TB.col(0).dot(kX), std::cos(0.025), 1e-4);
  EXPECT_GT(frame.R_TB.col(0).dot(a), frame.R_TB.col(0).dot(b));
}

TEST(FrameFromPlanes, GivesAThirdFamilyItsShare) {
  // x and y are exact; z's plane is 3 deg off about x: the answer shares the error between both.
  const Eigen::Vector3d third = so3_exp({0.05, 0.0, 0.0}) * kZ;
  const TargetFrame frame =
      frame_from_planes(planes_of({plane(kX, 100), plane(kY, 90), plane(-third, 80)}));
  expect_right_handed(frame.R_TB);
  EXPECT_NEAR(so3_log(frame.R_TB).x(), 0.025, 1e-3);
}

TEST(FrameFromPlanes, TakesAnObliquePlaneWhereNoneIsOrthogonal) {
  const Eigen::Vector3d oblique = so3_exp({0.0, 0.0, 0.9}) * kX;
  const TargetFrame frame = frame_from_planes(planes_of({plane(kX, 100), plane(oblique, 50)}));
  EXPECT_LT((frame.R_TB.col(1) - kY).norm(), 1e-9);  // its part across x
  EXPECT_TRUE(frame.axes_known[1]);
  // Within 30 deg of x it indicates little: as if it were not there.
  const Eigen::Vector3d near = so3_exp({0.0, 0.0, 0.4}) * kX;
  EXPECT_FALSE(frame_from_planes(planes_of({plane(kX, 100), plane(near, 50)})).axes_known[1]);
}

TEST(FrameFromPlanes, OfOneFaceTakesTheLongEdge_AndDoesNotClaimASquaresEdges) {
  Plane face = plane(kX, 100);
  face.axes_T.col(0) = Eigen::Vector3d(0.0, 1.0, 1.0).normalized();
  face.extents = {2.0, 1.0};
  const TargetFrame rectangle = frame_from_planes(planes_of({face}));
  EXPECT_NEAR(std::abs(rectangle.R_TB.col(1).dot(face.axes_T.col(0))), 1.0, 1e-12);
  EXPECT_EQ(rectangle.axes_known, (std::array{true, true, true}));
  face.extents = {1.05, 1.0};
  const TargetFrame square = frame_from_planes(planes_of({face}));
  EXPECT_EQ(square.axes_known, (std::array{true, false, false}));
}

TEST(FrameFromCylinder, TakesXFromAPlaneAcrossTheAxis_ElseFromT) {
  Cylinder cylinder;
  cylinder.axis_T = so3_exp({0.2, 0.1, 0.0}) * kZ;
  const Eigen::Vector3d across = cylinder.axis_T.unitOrthogonal();
  const TargetFrame with =
      frame_from_cylinder(cylinder, planes_of({plane(cylinder.axis_T, 90), plane(across, 50)}));
  EXPECT_LT((with.R_TB.col(2) - cylinder.axis_T).norm(), 1e-12);
  EXPECT_LT((with.R_TB.col(0) - across).norm(), 1e-12);
  EXPECT_EQ(with.axes_known, (std::array{true, true, true}));
  const TargetFrame without = frame_from_cylinder(cylinder, {});
  EXPECT_EQ(without.axes_known, (std::array{false, false, true}));
  EXPECT_EQ(without.source, FrameSource::kCylinder);
  EXPECT_GT(without.R_TB.col(0).dot(kX), 0.99);  // the axis of T that lies most across
  expect_right_handed(without.R_TB);
}

/// Corners of a box: their spread is along its edges.
std::vector<Eigen::Vector3d> corners(const Eigen::Vector3d& size, const Eigen::Matrix3d& R) {
  std::vector<Eigen::Vector3d> out;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      for (const double z : {-0.5, 0.5}) {
        out.push_back(R * Eigen::Vector3d(x * size.x(), y * size.y(), z * size.z()) +
                      Eigen::Vector3d(3.0, 2.0, 1.0));
      }
    }
  }
  return out;
}

TEST(FrameFromPoints, TakesXAlongTheLargestSpreadAndZAlongTheLeast) {
  const Eigen::Matrix3d R = so3_exp({0.3, -0.5, 0.8});
  const TargetFrame frame = frame_from_points(corners({1.0, 3.0, 2.0}, R));
  EXPECT_NEAR(std::abs(frame.R_TB.col(0).dot(R.col(1))), 1.0, 1e-12);
  EXPECT_NEAR(std::abs(frame.R_TB.col(2).dot(R.col(0))), 1.0, 1e-12);
  EXPECT_EQ(frame.axes_known, (std::array{true, true, true}));
  EXPECT_EQ(frame.source, FrameSource::kPrincipal);
  expect_right_handed(frame.R_TB);
}

TEST(FrameFromPoints, ClaimsNoAxesWhoseSpreadsAreAlike) {
  const Eigen::Matrix3d R = so3_exp({0.3, -0.5, 0.8});
  EXPECT_EQ(frame_from_points(corners({1.0, 1.0, 1.0}, R)).axes_known,
            (std::array{false, false, false}));
  EXPECT_EQ(frame_from_points(corners({3.0, 1.0, 1.0}, R)).axes_known,
            (std::array{true, false, false}));
  EXPECT_EQ(frame_from_points(corners({2.0, 2.0, 1.0}, R)).axes_known,
            (std::array{false, false, true}));
  // A line has a direction, and nothing across it.
  EXPECT_EQ(frame_from_points(corners({1.0, 0.0, 0.0}, R)).axes_known,
            (std::array{true, false, false}));
}

TEST(RelabelLike, FindsTheNamesOfBefore_WhicheverOfTheTwentyFourItIs) {
  const TargetFrame previous{.R_TB = so3_exp({0.3, -0.5, 0.8}),
                             .source = FrameSource::kPlanes,
                             .axes_known = {true, false, false}};
  // The same axes a little later, named again: x is now -z, y is x, z is -y.
  const Eigen::Matrix3d later = so3_exp({0.02, 0.01, -0.03}) * previous.R_TB;
  TargetFrame frame = previous;
  frame.R_TB.col(0) = -later.col(2);
  frame.R_TB.col(1) = later.col(0);
  frame.R_TB.col(2) = -later.col(1);
  frame.axes_known = {false, true, false};
  ASSERT_NEAR(frame.R_TB.determinant(), 1.0, 1e-12);
  const TargetFrame named = relabel_like(frame, previous);
  EXPECT_LT((named.R_TB - later).norm(), 1e-12);
  EXPECT_EQ(named.axes_known, (std::array{true, false, false}));
}

TEST(RelabelLike, LeavesARoundBodysTurnAboutItsAxisAsItWas) {
  const TargetFrame previous{.R_TB = so3_exp({0.3, -0.5, 0.8}),
                             .source = FrameSource::kCylinder,
                             .axes_known = {false, false, true}};
  // The axis comes out with the other sign, turned by an angle that nothing fixes.
  TargetFrame frame = previous;
  frame.R_TB = previous.R_TB * so3_exp({0.0, 0.0, 1.1}) * so3_exp({3.14159265358979, 0.0, 0.0});
  const TargetFrame named = relabel_like(frame, previous);
  EXPECT_LT((named.R_TB - previous.R_TB).norm(), 1e-9);
  EXPECT_EQ(named.axes_known, (std::array{false, false, true}));
}

TEST(RelabelLike, KeepsARoundBodysOwnX_WhereAPlaneFixesIt) {
  const TargetFrame previous{.R_TB = so3_exp({0.3, -0.5, 0.8}),
                             .source = FrameSource::kCylinder,
                             .axes_known = {true, true, true}};
  TargetFrame frame = previous;
  frame.R_TB = previous.R_TB * so3_exp({0.0, 0.0, 0.3});
  EXPECT_LT((relabel_like(frame, previous).R_TB - frame.R_TB).norm(), 1e-12);
}

TEST(RelabelLike, KeepsTheNameThatTheAxisHadInABox) {
  // The round was found only now: its axis is what had been called x.
  const TargetFrame previous{.R_TB = Eigen::Matrix3d::Identity(), .source = FrameSource::kPlanes};
  Cylinder cylinder;
  cylinder.axis_T = -kX;
  const TargetFrame named = relabel_like(frame_from_cylinder(cylinder, {}), previous);
  EXPECT_LT((named.R_TB - previous.R_TB).norm(), 1e-9);
  EXPECT_EQ(named.axes_known, (std::array{true, false, false}));
  EXPECT_EQ(named.source, FrameSource::kCylinder);
}

}  // namespace
}  // namespace polhode::target_frame_test
