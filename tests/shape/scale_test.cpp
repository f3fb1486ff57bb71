#include "shape/scale.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "surfaces.hpp"

namespace polhode::scale_test {
namespace {

constexpr double kMetresPerMu = 0.37;

struct Scene {
  Points landmarks_T;
  Pose pose;
  Placement at{.R_TB = Eigen::Matrix3d::Identity(), .centre_T = Eigen::Vector3d::Zero()};

  [[nodiscard]] ScaleView view() const { return {.pose = pose, .landmarks_T = landmarks_T}; }
  [[nodiscard]] Eigen::Vector2d ray(const Eigen::Vector3d& p_T) const {
    return pose.to_camera(p_T).hnormalized();
  }
};

/// A box 1 x 0.8 x 0.6 about T's origin, 6 away, its -z side turned by 0.5 rad from the camera.
/// Sides +x, -y and -z face it.
Scene box_scene(double sigma, std::uint64_t seed) {
  Scene scene;
  scene.landmarks_T = box_points(
      {1.0, 0.8, 0.6}, {false, true, true, false, true, false}, 800, sigma, seed, scene.at);
  scene.pose.R_CT = so3_exp({0.3, 0.4, 0.1});
  scene.pose.p_CT = {0.2, -0.1, 6.0};
  return scene;
}

// Both on the near face z = -0.3, which faces the camera.
const Eigen::Vector3d kEndA(-0.4, -0.3, -0.3);
const Eigen::Vector3d kEndB(0.35, 0.25, -0.3);

TEST(ScaleFromLength, IsExactOnExactLandmarks) {
  const Scene scene = box_scene(0.0, 1);
  const double known_m = kMetresPerMu * (kEndB - kEndA).norm();
  const Result<ScaleEstimate> scale =
      scale_from_length(scene.view(), scene.ray(kEndA), scene.ray(kEndB), known_m, 0.0);
  ASSERT_TRUE(scale.ok());
  // A landmark of the next side within the band (0.03 of 1) next to the edge may join the plane of
  // a dozen.
  EXPECT_NEAR(scale.value().metres_per_mu, kMetresPerMu, 1e-3 * kMetresPerMu);
}

// verifies: SHP-08
TEST(ScaleFromLength, HasAnHonestSigma) {
  constexpr int kSeeds = 200;
  constexpr double kPick = 0.0004;
  int beyond = 0;
  double square = 0.0;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Scene scene = box_scene(0.01, seed);
    Rng rng(seed, 77);
    const Eigen::Vector2d pick_a =
        scene.ray(kEndA) + kPick * Eigen::Vector2d(rng.normal(), rng.normal());
    const Eigen::Vector2d pick_b =
        scene.ray(kEndB) + kPick * Eigen::Vector2d(rng.normal(), rng.normal());
    const double known_m = kMetresPerMu * (kEndB - kEndA).norm();
    const Result<ScaleEstimate> scale =
        scale_from_length(scene.view(), pick_a, pick_b, known_m, kPick);
    ASSERT_TRUE(scale.ok());
    const double normalised = (scale.value().metres_per_mu - kMetresPerMu) / scale.value().sigma;
    beyond += std::abs(normalised) > 1.96 ? 1 : 0;
    square += normalised * normalised;
  }
  // 10 of 200 expected beyond the 95 % bound, with a standard deviation of 3.1; a dozen landmarks
  // give a sigma that is itself known to 20 %, so a few more are allowed. Not ten times too wide:
  // mean square over 0.25.
  EXPECT_LE(beyond, 26);
  EXPECT_GT(square / kSeeds, 0.25);
}

TEST(ScaleFromLength, ResistsWrongLandmarks) {
  Scene scene = box_scene(0.003, 3);
  Rng rng(3, 5);
  for (std::size_t i = 0; i < scene.landmarks_T.size(); i += 8) {
    scene.landmarks_T[i] += noise(rng, 0.3);
  }
  const double known_m = kMetresPerMu * (kEndB - kEndA).norm();
  const Result<ScaleEstimate> scale =
      scale_from_length(scene.view(), scene.ray(kEndA), scene.ray(kEndB), known_m, 0.0);
  ASSERT_TRUE(scale.ok());
  EXPECT_NEAR(scale.value().metres_per_mu, kMetresPerMu, 0.05 * kMetresPerMu);
}

TEST(ScaleFromLength, IsAnErrorWhereNothingCanBeSaid) {
  const Scene scene = box_scene(0.002, 4);
  const Eigen::Vector2d a = scene.ray(kEndA);
  const Eigen::Vector2d b = scene.ray(kEndB);
  EXPECT_EQ(scale_from_length(scene.view(), a, b, 0.0, 0.0).error().code, ErrorCode::kBadParameter);
  EXPECT_EQ(scale_from_length(scene.view(), a, b, -1.0, 0.0).error().code,
            ErrorCode::kBadParameter);
  EXPECT_EQ(scale_from_length(scene.view(), a, a, 1.0, 0.0005).error().code,
            ErrorCode::kDegenerate);
  EXPECT_EQ(scale_from_length(scene.view(), a, {0.9, 0.9}, 1.0, 0.0).error().code,
            ErrorCode::kDegenerate);
  EXPECT_EQ(scale_from_length({.pose = scene.pose, .landmarks_T = {}}, a, b, 1.0, 0.0).error().code,
            ErrorCode::kTooFewObservations);
  Scene behind = scene;
  behind.pose.p_CT.z() = -6.0;
  EXPECT_EQ(scale_from_length(behind.view(), a, b, 1.0, 0.0).error().code,
            ErrorCode::kTooFewObservations);
}

TEST(ScaleFromRange, MeasuresTheNearSide) {
  Scene scene = box_scene(0.002, 5);
  scene.pose.p_CT = {0.0, 0.0, 6.0};
  // The boresight meets the side z = -0.3: n . (R^T (z_C - p)) = -0.3 along T's z.
  const Eigen::Vector3d normal_C = scene.pose.R_CT * Eigen::Vector3d::UnitZ();
  const double depth = (normal_C.dot(scene.pose.p_CT) - 0.3) / normal_C.z();
  const Result<ScaleEstimate> scale = scale_from_range(scene.view(), kMetresPerMu * depth, 0.001);
  ASSERT_TRUE(scale.ok());
  EXPECT_NEAR(scale.value().metres_per_mu, kMetresPerMu, 0.002 * kMetresPerMu);
  EXPECT_GT(scale.value().sigma, kMetresPerMu * 0.001 / (kMetresPerMu * depth) * 0.999);
}

TEST(ScaleFromRange, IsAnErrorWhenTheBoresightMissesOrTheReadingIsNone) {
  Scene scene = box_scene(0.002, 6);
  EXPECT_EQ(scale_from_range(scene.view(), 0.0, 0.0).error().code, ErrorCode::kBadParameter);
  scene.pose.p_CT = {3.0, 0.0, 6.0};
  EXPECT_EQ(scale_from_range(scene.view(), 2.0, 0.0).error().code, ErrorCode::kDegenerate);
}

}  // namespace
}  // namespace polhode::scale_test
