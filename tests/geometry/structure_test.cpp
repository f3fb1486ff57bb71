// Two-view relations and alignment on exact and on noisy data.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "base/rng.hpp"
#include "geometry/alignment.hpp"
#include "geometry/epipolar.hpp"
#include "geometry/so3.hpp"

namespace polhode::structure_test {
namespace {

Eigen::Vector3d random_vector(Rng& rng, double size) {
  return size * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
}

Pose random_pose(Rng& rng) {
  return {.R_CT = so3_exp(random_vector(rng, 0.3)),
          .p_CT = random_vector(rng, 0.2) + Eigen::Vector3d(0.0, 0.0, 6.0)};
}

TEST(Epipolar, RelativePoseTakesPointsFromOneViewToTheOther) {
  Rng rng(1, 0);
  for (int i = 0; i < 50; ++i) {
    const Pose a = random_pose(rng);
    const Pose b = random_pose(rng);
    const Eigen::Vector3d p_T = random_vector(rng, 0.5);
    const RelativePose motion = relative_pose(a, b);
    EXPECT_LT((motion.R_ba * a.to_camera(p_T) + motion.p_ba - b.to_camera(p_T)).norm(), 1e-13);
  }
}

TEST(Epipolar, ErrorVanishesForTrueMatchesAndIsTheirDistanceOtherwise) {
  Rng rng(2, 0);
  for (int i = 0; i < 50; ++i) {
    const Pose a = random_pose(rng);
    const Pose b = random_pose(rng);
    const Eigen::Vector3d p_T = random_vector(rng, 0.5);
    const Eigen::Matrix3d E = essential_matrix(relative_pose(a, b));
    const Eigen::Vector2d x_a = a.to_camera(p_T).hnormalized();
    const Eigen::Vector2d x_b = b.to_camera(p_T).hnormalized();
    EXPECT_NEAR(sampson_error(E, x_a, x_b), 0.0, 1e-13);
    // Moved across its line in b by d, the nearest pair that fits shares the way between both
    // images: d times the ratio of the line's gradient in b to that in both.
    const Eigen::Vector3d line_b = E * x_a.homogeneous();
    const Eigen::Vector3d line_a = E.transpose() * x_b.homogeneous();
    const Eigen::Vector2d across = line_b.head<2>().normalized();
    const double d = 1e-6;
    const double share =
        line_b.head<2>().norm() / std::hypot(line_b.head<2>().norm(), line_a.head<2>().norm());
    EXPECT_NEAR(sampson_error(E, x_a, x_b + d * across), d * share, 1e-4 * d);
  }
}

TEST(Epipolar, OfNoBaselineIsZeroNotUndefined) {
  EXPECT_EQ(sampson_error(Eigen::Matrix3d::Zero(), {0.1, 0.2}, {0.3, 0.4}), 0.0);
}

TEST(Alignment, FindsTheScaleAndShiftThatWereApplied) {
  Rng rng(6, 0);
  for (int trial = 0; trial < 50; ++trial) {
    const Similarity truth{.scale = 0.1 + 3.0 * rng.uniform(),
                           .R_ba = so3_exp(random_vector(rng, 1.5)),
                           .t_ba = random_vector(rng, 4.0)};
    std::vector<Eigen::Vector3d> a;
    std::vector<Eigen::Vector3d> b;
    std::vector<double> weights;
    for (int i = 0; i < 2 + trial % 5; ++i) {
      a.push_back(random_vector(rng, 1.0));
      b.push_back(truth.apply(a.back()));
      weights.push_back(0.1 + rng.uniform());
    }
    const Result<Similarity> found = align_rotated(a, b, weights, truth.R_ba);
    ASSERT_TRUE(found.ok());
    EXPECT_NEAR(found.value().scale, truth.scale, 1e-12 * 10);
    EXPECT_EQ(found.value().R_ba, truth.R_ba);
    EXPECT_LT((found.value().t_ba - truth.t_ba).norm(), 1e-9);
  }
}

TEST(Alignment, ATransformedPoseSeesThePointsWhereTheyWere) {
  Rng rng(7, 0);
  for (int trial = 0; trial < 50; ++trial) {
    const Similarity b_of_a{.scale = 0.1 + 3.0 * rng.uniform(),
                            .R_ba = so3_exp(random_vector(rng, 1.5)),
                            .t_ba = random_vector(rng, 4.0)};
    const Pose pose_a{.R_CT = so3_exp(random_vector(rng, 1.5)), .p_CT = random_vector(rng, 4.0)};
    const Eigen::Vector3d p_a = random_vector(rng, 1.0);
    const Eigen::Vector3d p_C = transformed(pose_a, b_of_a).to_camera(b_of_a.apply(p_a));
    EXPECT_LT((p_C - b_of_a.scale * pose_a.to_camera(p_a)).norm(), 1e-13);  // sums of some tens
  }
}

TEST(Alignment, IgnoresPointsOfNoWeight) {
  Rng rng(7, 0);
  std::vector<Eigen::Vector3d> a;
  std::vector<Eigen::Vector3d> b;
  std::vector<double> weights;
  for (int i = 0; i < 10; ++i) {
    a.push_back(random_vector(rng, 1.0));
    b.push_back(i < 8 ? a.back() : random_vector(rng, 50.0));
    weights.push_back(i < 8 ? 1.0 : 0.0);
  }
  const Similarity found = align_rotated(a, b, weights, Eigen::Matrix3d::Identity()).value();
  EXPECT_NEAR(found.scale, 1.0, 1e-12);
  EXPECT_LT(found.t_ba.norm(), 1e-12);
}

TEST(Alignment, RefusesWhatHasNoExtentOrNoWeight_AndAMirroredTurn) {
  const Eigen::Matrix3d same_axes = Eigen::Matrix3d::Identity();
  const std::vector<Eigen::Vector3d> line{{0.0, 0.0, 0.0}, {1.0, 1.0, 0.0}, {2.0, 2.0, 0.0}};
  const std::vector<Eigen::Vector3d> same(3, Eigen::Vector3d::Ones());
  const std::vector<double> ones(3, 1.0);
  EXPECT_EQ(align_rotated({}, {}, {}, same_axes).error().code, ErrorCode::kTooFewObservations);
  EXPECT_EQ(align_rotated(line, line, std::vector<double>(3, 0.0), same_axes).error().code,
            ErrorCode::kTooFewObservations);
  EXPECT_EQ(align_rotated(same, same, ones, same_axes).error().code, ErrorCode::kDegenerate);
  const Eigen::Matrix3d away = so3_exp(Eigen::Vector3d(0.0, 0.0, 3.14));
  EXPECT_EQ(align_rotated(line, line, ones, away).error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace polhode::structure_test
