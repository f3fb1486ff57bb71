// Camera model, reprojection and their derivatives.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "base/rng.hpp"
#include "geometry/camera_model.hpp"
#include "geometry/reprojection.hpp"
#include "geometry/so3.hpp"
#include "numeric_jacobian.hpp"

namespace polhode::camera_test {
namespace {

CameraModel camera() {
  return {.width_px = 1920,
          .height_px = 1080,
          .fu_px = 2667.0,
          .fv_px = 2650.0,
          .cu_px = 959.5,
          .cv_px = 539.5,
          .k1 = -0.28,
          .k2 = 0.07,
          .p1 = 0.0008,
          .p2 = -0.0004};
}

Eigen::Vector3d random_vector(Rng& rng, double size) {
  return size * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
}

struct Scene {
  Pose pose;
  Eigen::Vector3d p_T;
};

Scene random_scene(Rng& rng) {
  Scene scene;
  scene.pose.R_CT = so3_exp(random_vector(rng, 1.0));
  scene.pose.p_CT = random_vector(rng, 0.5) + Eigen::Vector3d(0.0, 0.0, 8.0);
  scene.p_T = random_vector(rng, 0.5);
  return scene;
}

TEST(Camera, ProjectsTheAxisToThePrincipalPointAndLinearlyWithoutDistortion) {
  CameraModel plain = camera();
  plain.k1 = plain.k2 = plain.p1 = plain.p2 = 0.0;
  EXPECT_EQ(project_px(plain, Eigen::Vector3d(0.0, 0.0, 3.0)), Eigen::Vector2d(959.5, 539.5));
  const Eigen::Vector2d pixel = project_px(plain, Eigen::Vector3d(0.3, -0.2, 3.0));
  EXPECT_NEAR(pixel.x(), 959.5 + 266.7, 1e-9);
  EXPECT_NEAR(pixel.y(), 539.5 - 2650.0 * 0.2 / 3.0, 1e-9);
  EXPECT_NEAR(plain.focal_px(), std::sqrt(2667.0 * 2650.0), 1e-9);
}

TEST(Camera, DistortsAsTheRadialTangentialModelSays) {
  // By hand for (x, y) = (0.2, 0.1): r2 = 0.05, radial 1 - 0.014 + 0.000175 = 0.986175;
  // x' = 0.197235 + 2 p1 x y + p2 (r2 + 2 x^2) = 0.197235 + 0.000032 - 0.000052.
  const Eigen::Vector2d pixel = project_px(camera(), Eigen::Vector2d(0.2, 0.1));
  EXPECT_NEAR(pixel.x(), 2667.0 * 0.197215 + 959.5, 1e-9);
  // y' = 0.0986175 + p1 (r2 + 2 y^2) + 2 p2 x y = 0.0986175 + 0.000056 - 0.000016.
  EXPECT_NEAR(pixel.y(), 2650.0 * 0.0986575 + 539.5, 1e-9);
}

TEST(Camera, UndistortUndoesProjectOverTheWholeImage) {
  const CameraModel model = camera();
  for (double v = 0.0; v < model.height_px; v += 107.0) {
    for (double u = 0.0; u < model.width_px; u += 191.0) {
      const Eigen::Vector2d normalised = undistort(model, {u, v});
      EXPECT_LT((project_px(model, normalised) - Eigen::Vector2d(u, v)).norm(), 1e-9)
          << u << " " << v;
    }
  }
}

TEST(Reprojection, OfTheInverseDepthPoseEqualsTheProjection) {
  Rng rng(1, 0);
  for (int i = 0; i < 200; ++i) {
    const Scene scene = random_scene(rng);
    const InverseDepthPose inverse = to_inverse_depth(scene.pose);
    Eigen::Vector2d normalised;
    ASSERT_TRUE(reproject(inverse, scene.p_T, &normalised));
    EXPECT_LT((normalised - scene.pose.to_camera(scene.p_T).hnormalized()).norm(), 1e-14);
    const Pose back = from_inverse_depth(inverse);
    EXPECT_LT((back.p_CT - scene.pose.p_CT).norm(), 1e-13);
    EXPECT_EQ(back.R_CT, scene.pose.R_CT);
    EXPECT_LT(scene.pose.to_camera(scene.pose.camera_T()).norm(), 1e-13);
  }
}

TEST(Reprojection, RefusesPointsInOrBehindTheCamera) {
  Pose pose;
  pose.p_CT = {0.0, 0.0, 2.0};
  const InverseDepthPose inverse = to_inverse_depth(pose);
  Eigen::Vector2d normalised;
  EXPECT_FALSE(reproject(inverse, {0.0, 0.0, -2.0}, &normalised));
  EXPECT_FALSE(reproject(inverse, {0.0, 0.0, -5.0}, &normalised));
  ReprojectionJacobians jacobians;
  EXPECT_FALSE(reproject(inverse, {0.0, 0.0, -2.0}, &normalised, &jacobians));
  InverseDepthPose nowhere = inverse;
  nowhere.uvs.z() = 0.0;
  EXPECT_FALSE(reproject(nowhere, {0.0, 0.0, 0.0}, &normalised));
}

TEST(Reprojection, HasTheDerivativesThatDifferencesGive) {
  Rng rng(2, 0);
  const auto at = [](const InverseDepthPose& pose, const Eigen::Vector3d& p_T) {
    Eigen::Vector2d normalised;
    EXPECT_TRUE(reproject(pose, p_T, &normalised));
    return normalised;
  };
  for (int i = 0; i < 100; ++i) {
    const Scene scene = random_scene(rng);
    const InverseDepthPose pose = to_inverse_depth(scene.pose);
    Eigen::Vector2d normalised;
    ReprojectionJacobians analytic;
    ASSERT_TRUE(reproject(pose, scene.p_T, &normalised, &analytic));
    EXPECT_EQ(normalised, at(pose, scene.p_T));
    const auto rotation = numeric_jacobian<2, 3>([&](const Eigen::Vector3d& phi) {
      return at({.R_CT = so3_exp(phi) * pose.R_CT, .uvs = pose.uvs}, scene.p_T);
    });
    const auto uvs = numeric_jacobian<2, 3>([&](const Eigen::Vector3d& d) {
      return at({.R_CT = pose.R_CT, .uvs = pose.uvs + d}, scene.p_T);
    });
    const auto point =
        numeric_jacobian<2, 3>([&](const Eigen::Vector3d& d) { return at(pose, scene.p_T + d); });
    EXPECT_LT((analytic.rotation - rotation).norm(), 1e-8);
    EXPECT_LT((analytic.uvs - uvs).norm(), 1e-8);
    EXPECT_LT((analytic.point - point).norm(), 1e-8);
  }
}

TEST(Reprojection, InverseDepthHasTheDerivativeThatDifferencesGive) {
  Rng rng(4, 0);
  for (int i = 0; i < 100; ++i) {
    const Pose pose = random_scene(rng).pose;
    const auto numeric = numeric_jacobian<3, 3>([&](const Eigen::Vector3d& d) -> Eigen::Vector3d {
      return to_inverse_depth({.R_CT = pose.R_CT, .p_CT = pose.p_CT + d}).uvs;
    });
    EXPECT_LT((uvs_by_position(pose.p_CT) - numeric).norm(), 1e-8);
  }
}

TEST(Reprojection, PoseErrorJacobianIsThatOfTheProjection) {
  Rng rng(3, 0);
  for (int i = 0; i < 100; ++i) {
    const Scene scene = random_scene(rng);
    const auto numeric =
        numeric_jacobian<2, 6>([&](const Eigen::Matrix<double, 6, 1>& d) -> Eigen::Vector2d {
          const Pose moved{.R_CT = so3_exp(d.head<3>()) * scene.pose.R_CT,
                           .p_CT = scene.pose.p_CT + d.tail<3>()};
          return moved.to_camera(scene.p_T).hnormalized();
        });
    EXPECT_LT((projection_jacobian(scene.pose, scene.p_T) - numeric).norm(), 1e-8);
  }
}

}  // namespace
}  // namespace polhode::camera_test
