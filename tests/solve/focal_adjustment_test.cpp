#include "solve/focal_adjustment.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "focal_scene.hpp"

namespace polhode::focal_adjustment_test {
namespace {

using testing::focal_scene;
using Scene = testing::BundleScene;

constexpr BundleOptions kOptions{.iterations_max = 60, .cauchy_sigma = 2.0};

TEST(AdjustFocal, FindsTheTrueOne_WithinItsSigma) {
  for (const double part : {0.7, 0.85, 1.0, 1.15, 1.3}) {
    Scene s = focal_scene(part, 5);
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

FocalReport report(double factor, double sigma) {
  return {.usable = true, .factor = factor, .relative_sigma = sigma};
}

TEST(FocalVerdict, RefutesBearsOutOrLeavesOpen) {
  for (const double factor : {0.9, 1.0 / 0.9}) {
    EXPECT_TRUE(refutes_focal(report(factor, 0.02)));
    EXPECT_FALSE(refutes_focal(report(factor, 0.03))) << "four sigma are more than that";
  }
  EXPECT_FALSE(refutes_focal(report(1.07, 0.001)));
  EXPECT_FALSE(refutes_focal({}));
  EXPECT_TRUE(bears_focal_out(report(1.02, 0.01)));
  EXPECT_FALSE(bears_focal_out(report(1.02, 0.03))) << "8 % would not have been found";
  EXPECT_FALSE(bears_focal_out(report(0.9, 0.01)));
  EXPECT_FALSE(bears_focal_out({}));
}

TEST(FocalVerdict, OnlyARefutedOneIsOff) {
  EXPECT_NEAR(part_off(report(0.9, 0.01)), 0.105, 0.001);  // the logarithm of 0.9
  EXPECT_EQ(part_off(report(0.95, 0.01)), 0.0);
  EXPECT_EQ(part_off({}), 0.0);
}

TEST(AdjustFocal, OfAFarBodyTheSigmaIsWide) {
  // At a hundred radii the perspective is 1 % of the images: a tenth of the focal length is 0.5 px.
  Scene s = focal_scene(1.0, 6, 100.0);
  const FocalReport found = adjust_focal(s.problem(), kOptions);
  ASSERT_TRUE(found.usable);
  Scene near = focal_scene(1.0, 6);
  EXPECT_GT(found.relative_sigma, 10.0 * adjust_focal(near.problem(), kOptions).relative_sigma);
}

TEST(AdjustFocal, ChangesNothing_AndBoundsItsWork) {
  Scene s = focal_scene(0.85, 7);
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
}  // namespace polhode::focal_adjustment_test
