// Confirmed landmarks with what is known of each. Poses from the map at rest: tests/replay.
#include "pipeline/smooth.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "../map/synthetic_map.hpp"
#include "solve/triangulate.hpp"

namespace polhode::smooth_test {
namespace {

using namespace synthetic;

constexpr double kStep_rad = 0.1;
constexpr int kPoses = 12;

SyntheticMap seen_with(double noise_px) {
  return make_map(ball(400, 7), turn_by(kStep_rad, kPoses), noise_px, 7);
}

/// 1-sigma along the worst axis, as triangulation from the same image points has it.
double sigma_by_triangulation(const Map& map, std::int32_t number) {
  std::vector<RayObservation> rays;
  for (const Keyframe& keyframe : map.keyframes) {
    for (std::size_t i = 0; keyframe.used && i < keyframe.features.size(); ++i) {
      const LandmarkId id = keyframe.landmark_of[i];
      if (id.valid() && map.landmarks[id.index()].number == number) {
        const Feature& f = keyframe.features[i];
        rays.push_back({.pose = keyframe.pose,
                        .normalised = f.normalised,
                        .sigma_normalised = static_cast<double>(f.sigma_px) / camera().focal_px()});
      }
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(
      triangulate(rays).value().covariance_T);
  return std::sqrt(eigen.eigenvalues()(2));
}

TEST(ConfirmedLandmarks, HaveTheSigmaOfTheirImagePoints) {
  const SyntheticMap s = seen_with(0.0);
  const ConfirmedLandmarks found = confirmed_landmarks(*s.map, camera());
  ASSERT_GT(found.points_T.size(), 80U);
  for (std::size_t i = 0; i < found.points_T.size(); ++i) {
    EXPECT_GE(found.views[i], 3);
    EXPECT_NEAR(found.directions_T[i].norm(), 1.0, 1e-9);
    EXPECT_GT(found.directions_T[i].dot(found.points_T[i]), 0.0);  // a ball is seen from outside
    const double expected = sigma_by_triangulation(*s.map, found.numbers[i]);
    EXPECT_NEAR(found.sigmas[i], expected, 1e-3 * expected) << i;
  }
}

TEST(ConfirmedLandmarks, HaveALargerSigmaWhereTheImagePointsAreWorseThanTheySay) {
  const ConfirmedLandmarks exact = confirmed_landmarks(*seen_with(kNoise_px).map, camera());
  const ConfirmedLandmarks worse = confirmed_landmarks(*seen_with(3.0 * kNoise_px).map, camera());
  ASSERT_GT(exact.sigmas.size(), 80U);
  ASSERT_GT(worse.sigmas.size(), 80U);
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  };
  // Some thousand residuals give their scale to some per cent.
  EXPECT_NEAR(mean(worse.sigmas) / mean(exact.sigmas), 3.0, 0.3);
}

}  // namespace
}  // namespace polhode::smooth_test
