#include "app/cloud_details.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "../shape/surfaces.hpp"

namespace polhode::platform::cloud_details_test {
namespace {

constexpr double kEdge_spacings = 1.0;  // ShapeOptions::voxel_spacings
constexpr double kSigma = 0.002;        // of a landmark

/// Landmarks on a body, each seen by three keyframes from straight above it.
struct Detailed {
  std::unique_ptr<ShapeWork> work = new_work();
  Shape shape;
  CloudDetails details;
};

Detailed detailed(const Points& points, const Placement& at) {
  Detailed found;
  ConfirmedLandmarks landmarks;
  for (const Eigen::Vector3d& point : points) {
    landmarks.points_T.push_back(point);
    landmarks.directions_T.push_back((point - at.centre_T).normalized());
    landmarks.views.push_back(3);
    landmarks.sigmas.push_back(kSigma);
  }
  found.shape = estimate_shape(points, ShapeOptions{}, 1, nullptr, *found.work).value();
  found.details =
      details_of(found.shape, *found.work, landmarks, kEdge_spacings * found.shape.spacing);
  return found;
}

std::size_t count_outward(const Detailed& body, const Placement& at, double cosine_min) {
  std::size_t outward = 0;
  for (std::size_t i = 0; i < body.details.normals_T.size(); ++i) {
    const Eigen::Vector3d apart_B =
        at.R_TB.transpose() * (body.work->cloud.points_T[i] - at.centre_T);
    const Eigen::Vector3d normal_B = at.R_TB.transpose() * body.details.normals_T[i];
    Eigen::Index side = 0;  // of a cube: the coordinate that sticks out most
    apart_B.cwiseAbs().maxCoeff(&side);
    outward += normal_B(side) * std::copysign(1.0, apart_B(side)) > cosine_min ? 1U : 0U;
  }
  return outward;
}

TEST(CloudDetails, OfABoxWithAnUnseenSide_PointOutOfTheBody) {
  const Placement at;
  // Five sides are seen; completion makes the sixth.
  const Detailed box = detailed(
      box_points({1.0, 1.0, 1.0}, {true, true, true, true, true, false}, 2500, 0.003, 3, at), at);
  const std::size_t measured = box.work->cloud.measured;
  const std::size_t all = box.work->cloud.points_T.size();
  ASSERT_EQ(box.shape.completion, CompletionKind::kBox);
  ASSERT_EQ(box.details.normals_T.size(), all);
  ASSERT_GT(all, measured + 50);
  // Points within a band of an edge may belong to either side: 12 edges, a band of some 0.03 each.
  EXPECT_GT(count_outward(box, at, 0.99), all * 9 / 10);
  for (std::size_t i = 0; i < all; ++i) {
    EXPECT_NEAR(box.details.normals_T[i].norm(), 1.0, 1e-6) << i;
    const bool added = i >= measured;
    EXPECT_EQ(box.details.views[i] == 0, added) << i;
    EXPECT_EQ(std::isnan(box.details.sigmas[i]), added) << i;
  }
}

TEST(CloudDetails, SigmaIsThatOfTheMeanAndOfTheCloud_ViewsAreSummed) {
  const Placement at;
  const Detailed box = detailed(box_points({1.0, 1.0, 1.0}, kAllSides, 2500, 0.003, 3, at), at);
  std::size_t views = 0;
  for (std::size_t i = 0; i < box.work->cloud.measured; ++i) {
    const int members = box.details.views[i] / 3;
    ASSERT_GE(members, 1);
    EXPECT_NEAR(
        box.details.sigmas[i], std::hypot(kSigma / std::sqrt(members), box.shape.thickness), 1e-6);
    views += static_cast<std::size_t>(box.details.views[i]);
  }
  // Every landmark is in one point, but for those that were outliers and share no cube.
  EXPECT_LE(views, 3U * 2500U);
  EXPECT_GT(views, 3U * 2400U);
}

TEST(CloudDetails, OfACylinder_AreRadialAndAlongItsAxis) {
  const Placement at;
  // Half of the round side is seen, with both ends.
  const Detailed tube =
      detailed(cylinder_points(0.5, 1.6, std::numbers::pi, 2500, 0.003, 4, at), at);
  ASSERT_EQ(tube.shape.completion, CompletionKind::kCylinder);
  std::size_t outward = 0;
  for (std::size_t i = 0; i < tube.details.normals_T.size(); ++i) {
    const Eigen::Vector3d p_B = at.R_TB.transpose() * (tube.work->cloud.points_T[i] - at.centre_T);
    const Eigen::Vector3d normal_B = at.R_TB.transpose() * tube.details.normals_T[i];
    const Eigen::Vector3d round = Eigen::Vector3d(p_B.x(), p_B.y(), 0.0).normalized();
    const double along = normal_B.z() * std::copysign(1.0, p_B.z());
    outward += std::max(normal_B.dot(round), along) > 0.97 ? 1U : 0U;
  }
  EXPECT_GT(outward, tube.details.normals_T.size() * 9 / 10);
}

}  // namespace
}  // namespace polhode::platform::cloud_details_test
