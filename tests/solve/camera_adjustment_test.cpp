#include "solve/camera_adjustment.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "camera_scene.hpp"
#include "solve/camera_verdict.hpp"

namespace polhode::camera_adjustment_test {
namespace {

using testing::camera_scene;
using testing::CameraScene;
using testing::deviating;

constexpr BundleOptions kOptions{.iterations_max = 60, .cauchy_sigma = 2.0};

struct Deviating {
  Deviation deviation;
  double value;
};

class AdjustCamera : public ::testing::TestWithParam<Deviating> {};

// verifies: MAP-11
TEST_P(AdjustCamera, FindsWhatDeviates_AndNothingElse) {
  const auto [deviation, value] = GetParam();
  CameraScene s = camera_scene(deviating(deviation, value), 5);
  const CameraFit fit = adjust_camera(s.problem(), kOptions);
  ASSERT_TRUE(fit.usable);
  EXPECT_GT(fit.cost_as_given, 1.2 * fit.cost_as_found);
  const CameraFinding found = find_deviations(fit);
  for (std::size_t i = 0; i < kDeviations; ++i) {
    const auto other = static_cast<Deviation>(i);
    const bool is_point = other == Deviation::kPrincipalU || other == Deviation::kPrincipalV;
    const bool point_is_off =
        deviation == Deviation::kPrincipalU || deviation == Deviation::kPrincipalV;
    EXPECT_EQ(found.is(other), other == deviation || (is_point && point_is_off)) << i;
  }
  EXPECT_NEAR(found.of(deviation), value, 3.0 * found.sigma_of(deviation));
  EXPECT_LT(found.sigma_of(deviation), 0.2 * std::abs(value));
}

INSTANTIATE_TEST_SUITE_P(OfEachKind,
                         AdjustCamera,
                         ::testing::Values(Deviating{Deviation::kFocal, 0.15},
                                           Deviating{Deviation::kFocal, -0.3},
                                           Deviating{Deviation::kZoom, 0.25},
                                           Deviating{Deviation::kAspect, 0.05},
                                           Deviating{Deviation::kAspect, -0.2},
                                           Deviating{Deviation::kPrincipalU, 0.03},
                                           Deviating{Deviation::kPrincipalV, -0.05},
                                           Deviating{Deviation::kReadout, 0.1},
                                           Deviating{Deviation::kHalf, 0.1}));

TEST(AdjustCameraRight, ContradictsNothing_WithinItsSigmas) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    CameraScene s = camera_scene(Deviations::Zero(), seed);
    const CameraFinding found = find_deviations(adjust_camera(s.problem(), kOptions));
    EXPECT_FALSE(found.any()) << seed;
    EXPECT_LT(found.value.cwiseQuotient(found.sigma).cwiseAbs().maxCoeff(), 3.0) << seed;
  }
}

TEST(AdjustCameraRight, OfAFarBodyTheSigmaIsWide) {
  // At a hundred radii the perspective is 1 % of the images: a tenth of the focal length is 0.5 px.
  CameraScene far = camera_scene(Deviations::Zero(), 6, {.distance = 100.0});
  CameraScene near = camera_scene(Deviations::Zero(), 6);
  const CameraFinding of_far = find_deviations(adjust_camera(far.problem(), kOptions));
  const CameraFinding of_near = find_deviations(adjust_camera(near.problem(), kOptions));
  ASSERT_GT(of_near.sigma_of(Deviation::kFocal), 0.0);
  for (const Deviation deviation : {Deviation::kFocal, Deviation::kPrincipalU}) {
    EXPECT_GT(of_far.sigma_of(deviation), 5.0 * of_near.sigma_of(deviation));
  }
}

TEST(AdjustCameraRight, WithoutMotionRowsGiveNothing) {
  CameraScene s = camera_scene(Deviations::Zero(), 6);
  std::fill(s.motions.begin(), s.motions.end(), PoseMotion{});
  const CameraFinding found = find_deviations(adjust_camera(s.problem(), kOptions));
  EXPECT_FALSE(found.any());
  EXPECT_GT(found.sigma_of(Deviation::kReadout), 0.5) << "as wide as the prior, or nearly";
}

TEST(AdjustCameraRight, ChangesNothing_AndBoundsItsWork) {
  CameraScene s = camera_scene(deviating(Deviation::kFocal, -0.15), 7);
  const CameraScene before = s;
  const CameraFit all = adjust_camera(s.problem(), kOptions);
  EXPECT_EQ(all.observations, s.bundle.observations.size());
  EXPECT_TRUE(s.bundle.points_T == before.bundle.points_T);
  EXPECT_EQ(s.bundle.poses[3].uvs, before.bundle.poses[3].uvs);
  BundleOptions less = kOptions;
  less.observations_max = 300;
  const CameraFit part = adjust_camera(s.problem(), less);
  EXPECT_LE(part.observations, 300U);
  EXPECT_NEAR(part.value[0], all.value[0], 0.05);
}

TEST(AdjustCameraRight, WithoutObservationsThereIsNone) {
  EXPECT_FALSE(adjust_camera({}, kOptions).usable);
}

}  // namespace
}  // namespace polhode::camera_adjustment_test
