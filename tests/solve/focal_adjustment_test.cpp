#include "solve/focal_adjustment.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bundle_scene.hpp"

namespace polhode {
namespace {

using testing::disturbed;
using testing::make_scene;
using Scene = testing::BundleScene;

constexpr BundleOptions kOptions{.iterations_max = 60, .cauchy_sigma = 2.0};

/// A body three radii away, seen by a camera whose focal length is taken for `part` of what it is.
Scene scene(double part, std::uint64_t seed, double distance = 3.0) {
  Scene s = make_scene(12, 60, 0.0, seed);
  Rng rng(seed, 91);
  for (InverseDepthPose& pose : s.poses) {
    pose.uvs.z() = 1.0 / distance;
  }
  for (BundleObservation& o : s.observations) {
    Eigen::Vector2d image = Eigen::Vector2d::Zero();
    const bool seen = reproject(s.poses[static_cast<std::size_t>(o.pose)],
                                s.points_T[static_cast<std::size_t>(o.point)],
                                &image);
    POLHODE_ASSERT(seen, o.point);
    image += testing::kBundleSigma * Eigen::Vector2d(rng.normal(), rng.normal());
    o.normalised = image / part;
    o.sigma_normalised = testing::kBundleSigma / part;
  }
  std::fill(s.pose_fixed.begin() + 1, s.pose_fixed.end(), std::uint8_t{0});
  return disturbed(s, seed, 0.2);
}

TEST(AdjustFocal, FindsTheTrueOne_WithinItsSigma) {
  for (const double part : {0.7, 0.85, 1.0, 1.15, 1.3}) {
    Scene s = scene(part, 5);
    const FocalReport found = adjust_focal(s.problem(), kOptions);
    ASSERT_TRUE(found.usable) << part;
    const double error = std::log(found.factor * part);
    EXPECT_LT(std::abs(error), 3.0 * found.relative_sigma) << part;
    EXPECT_LT(found.relative_sigma, 0.02) << part;
    if (part != 1.0) {  // the given one costs several times as much
      EXPECT_GT(found.cost_as_given, 1.2 * found.cost_at_factor) << part;
      EXPECT_GT(std::abs(std::log(found.factor)), 4.0 * found.relative_sigma) << part;
    }
  }
}

TEST(AdjustFocal, OfAFarBodyTheSigmaIsWide) {
  // At a hundred radii the perspective is 1 % of the images: a tenth of the focal length is 0.5 px.
  Scene s = scene(1.0, 6, 100.0);
  const FocalReport found = adjust_focal(s.problem(), kOptions);
  ASSERT_TRUE(found.usable);
  Scene near = scene(1.0, 6);
  EXPECT_GT(found.relative_sigma, 10.0 * adjust_focal(near.problem(), kOptions).relative_sigma);
}

TEST(AdjustFocal, ChangesNothing_AndBoundsItsWork) {
  Scene s = scene(0.85, 7);
  const Scene before = s;
  const FocalReport all = adjust_focal(s.problem(), kOptions);
  EXPECT_EQ(all.observations, s.observations.size());
  EXPECT_TRUE(s.points_T == before.points_T);
  EXPECT_EQ(s.poses[3].uvs, before.poses[3].uvs);
  BundleOptions less = kOptions;
  less.observations_max = 300;
  const FocalReport part = adjust_focal(s.problem(), less);
  EXPECT_LE(part.observations, 300U);
  EXPECT_NEAR(std::log(part.factor), std::log(all.factor), 3.0 * part.relative_sigma);
}

TEST(AdjustFocal, WithoutObservationsThereIsNone) {
  EXPECT_FALSE(adjust_focal({}, kOptions).usable);
}

}  // namespace
}  // namespace polhode
