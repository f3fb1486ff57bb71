#include "solve/reprojection_cost.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "base/rng.hpp"

namespace polhode {
namespace {

using Delta = Eigen::Matrix<double, 6, 1>;

Eigen::Vector3d normal3(Rng* rng) { return {rng->normal(), rng->normal(), rng->normal()}; }

InverseDepthPose random_pose(Rng* rng) {
  return {.R_CT = so3_exp(2.0 * normal3(rng)),
          .uvs = {0.1 * rng->normal(), 0.1 * rng->normal(), 0.05 + 0.1 * rng->uniform()}};
}

Delta random_delta(double size, Rng* rng) {
  Delta d;
  d << normal3(rng), 0.1 * normal3(rng);
  return size * d;
}

PoseBlock plus(const PoseBlock& x, const Delta& delta) {
  PoseBlock out{};
  EXPECT_TRUE(PoseManifold().Plus(x.data(), delta.data(), out.data()));
  return out;
}

Delta minus(const PoseBlock& y, const PoseBlock& x) {
  Delta out;
  EXPECT_TRUE(PoseManifold().Minus(y.data(), x.data(), out.data()));
  return out;
}

double difference(const PoseBlock& a, const PoseBlock& b) {
  return (from_block(a).R_CT - from_block(b).R_CT).norm() +
         (from_block(a).uvs - from_block(b).uvs).norm();
}

TEST(PoseBlock, ComesBackAsThePoseThatItWasMadeOf) {
  Rng rng(61, 0);
  for (int i = 0; i < 100; ++i) {
    const InverseDepthPose pose = random_pose(&rng);
    const InverseDepthPose back = from_block(to_block(pose));
    EXPECT_LT((back.R_CT - pose.R_CT).norm(), 1e-14);
    EXPECT_EQ(back.uvs, pose.uvs);
  }
}

TEST(PoseManifold, ObeysTheLawsOfPlusAndMinus) {
  Rng rng(62, 0);
  for (int i = 0; i < 100; ++i) {
    const PoseBlock x = to_block(random_pose(&rng));
    const PoseBlock y = to_block(random_pose(&rng));
    const Delta delta = random_delta(0.5, &rng);  // under pi, where the logarithm is one-to-one
    EXPECT_LT(difference(plus(x, Delta::Zero()), x), 1e-15);
    EXPECT_LT(difference(plus(x, minus(y, x)), y), 1e-12);
    EXPECT_LT(minus(x, x).norm(), 1e-12);
    if (delta.head<3>().norm() < 3.0) {
      EXPECT_LT((minus(plus(x, delta), x) - delta).norm(), 1e-10);
    }
  }
}

TEST(PoseManifold, IsExactForTinySteps) {
  Rng rng(63, 0);
  const PoseBlock x = to_block(random_pose(&rng));
  for (const double size : {1e-6, 1e-9, 1e-12}) {
    const Delta delta = random_delta(size, &rng);
    // Rounding of a rotation matrix near 1.
    EXPECT_LT((minus(plus(x, delta), x) - delta).norm(), 1e-14) << size;
  }
}

TEST(PoseManifold, KeepsTheQuaternionsLength_OverManySteps) {
  Rng rng(64, 0);
  PoseBlock x = to_block(random_pose(&rng));
  for (int i = 0; i < 1000; ++i) {
    x = plus(x, random_delta(0.3, &rng));
  }
  EXPECT_NEAR(std::hypot(std::hypot(x[0], x[1]), std::hypot(x[2], x[3])), 1.0, 1e-14);
}

struct Evaluation {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, kPoseBlockSize, Eigen::RowMajor> by_block;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
};

bool evaluate(const ReprojectionCost& cost,
              const PoseBlock& pose,
              const Eigen::Vector3d& point,
              Evaluation* out) {
  const double* parameters[2] = {pose.data(), point.data()};
  double* jacobians[2] = {out->by_block.data(), out->by_point.data()};
  return cost.Evaluate(parameters, out->residual.data(), jacobians);
}

Eigen::Vector2d residual(const ReprojectionCost& cost,
                         const PoseBlock& pose,
                         const Eigen::Vector3d& point) {
  Eigen::Vector2d r;
  const double* parameters[2] = {pose.data(), point.data()};
  EXPECT_TRUE(cost.Evaluate(parameters, r.data(), nullptr));
  return r;
}

TEST(ReprojectionCost, IsZero_WhereThePointProjects) {
  Rng rng(65, 0);
  for (int i = 0; i < 50; ++i) {
    const InverseDepthPose pose = random_pose(&rng);
    const Eigen::Vector3d point = normal3(&rng);
    const Eigen::Vector3d p_C = from_inverse_depth(pose).to_camera(point);
    const ReprojectionCost cost(p_C.hnormalized(), 1e-3);
    EXPECT_LT(residual(cost, to_block(pose), point).norm(), 1e-10);
  }
}

TEST(ReprojectionCost, CountsInSigma) {
  Rng rng(66, 0);
  const InverseDepthPose pose = random_pose(&rng);
  const Eigen::Vector3d point = normal3(&rng);
  const Eigen::Vector2d image = from_inverse_depth(pose).to_camera(point).hnormalized();
  const ReprojectionCost cost(image - Eigen::Vector2d(2e-3, -1e-3), 1e-3);
  EXPECT_LT((residual(cost, to_block(pose), point) - Eigen::Vector2d(2.0, -1.0)).norm(), 1e-9);
}

TEST(ReprojectionCost, HasTheNumericDerivatives) {
  Rng rng(67, 0);
  for (int i = 0; i < 50; ++i) {
    const PoseBlock pose = to_block(random_pose(&rng));
    const Eigen::Vector3d point = normal3(&rng);
    const ReprojectionCost cost({0.05, -0.02}, 1.0);
    Evaluation at;
    ASSERT_TRUE(evaluate(cost, pose, point, &at));
    Eigen::Matrix<double, kPoseBlockSize, 6, Eigen::RowMajor> lift;
    ASSERT_TRUE(PoseManifold().PlusJacobian(pose.data(), lift.data()));
    const Eigen::Matrix<double, 2, 6> by_tangent = at.by_block * lift;
    // Central differences with step h err by h^2 / 6 of the third derivative (order 1) and by 1e-16
    // / h: 1e-10 at 1e-5.
    constexpr double kStep = 1e-5;
    for (int k = 0; k < 6; ++k) {
      const Delta step = kStep * Delta::Unit(k);
      const Eigen::Vector2d numeric =
          (residual(cost, plus(pose, step), point) - residual(cost, plus(pose, -step), point)) /
          (2.0 * kStep);
      EXPECT_LT((numeric - by_tangent.col(k)).norm(), 1e-8) << "pose " << k;
    }
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(k);
      const Eigen::Vector2d numeric =
          (residual(cost, pose, point + step) - residual(cost, pose, point - step)) / (2.0 * kStep);
      EXPECT_LT((numeric - at.by_point.col(k)).norm(), 1e-8) << "point " << k;
    }
  }
}

TEST(ReprojectionCost, RefusesAPointBehindTheCamera) {
  const InverseDepthPose pose{.uvs = {0.0, 0.0, 0.5}};  // T's origin 2 in front
  const ReprojectionCost cost({0.0, 0.0}, 1e-3);
  Evaluation at;
  EXPECT_TRUE(evaluate(cost, to_block(pose), {0.0, 0.0, -1.9}, &at));
  EXPECT_FALSE(evaluate(cost, to_block(pose), {0.0, 0.0, -2.0}, &at));
  EXPECT_FALSE(evaluate(cost, to_block(pose), {0.0, 0.0, -3.0}, &at));
}

}  // namespace
}  // namespace polhode
