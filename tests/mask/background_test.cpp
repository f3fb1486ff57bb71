// What is behind the target, and over how many images it is compared.
#include "mask/background.hpp"

#include <gtest/gtest.h>

#include "moving_scene.hpp"

namespace polhode::background_test {
namespace {

using moving::Scene;

/// Points that were followed through the first images of a scene.
PointsState followed(const Scene& scene, int images) {
  PointsState points;
  for (int i = 0; i < images; ++i) {
    add_image(scene.image(i), {}, &points);
    follow_points(&points);
    refill_points({}, Refill::kEverywhere, &points);
  }
  return points;
}

/// A disc of a third of the image's height goes to the right, the room behind it to the left.
const Scene kScene{.background_px = {-0.6, 0.0}, .target_px = {1.0, 0.0}};

TEST(ExplainBackground, SeparatesAsManyPoints_ByOneAgeAsByBoth) {
  const PointsState before = followed(kScene, 10);
  const auto target_tracks = [&](FittedAges ages) {
    PointsState points = before;
    BackgroundState background;
    background.age = 2;
    EXPECT_TRUE(explain_background({}, 1, ages, &points, &background));
    EXPECT_EQ(background.motions[0].layers.empty(), ages == FittedAges::kLonger);
    EXPECT_EQ(background.motions[1].layers.empty(), ages == FittedAges::kShorter);
    return static_cast<double>(background.target_tracks);
  };
  const double both = target_tracks(FittedAges::kBoth);
  EXPECT_GT(both, 10.0);
  EXPECT_NEAR(target_tracks(FittedAges::kShorter), both, 0.2 * both);
  EXPECT_NEAR(target_tracks(FittedAges::kLonger), both, 0.2 * both);
}

TEST(ExplainBackground, TakesTheOtherAge_WhereTheOneRequestedHasNoMotion) {
  PointsState points = followed(kScene, 2);  // no image is two images old
  BackgroundState background;
  EXPECT_TRUE(explain_background({}, 1, FittedAges::kLonger, &points, &background));
  EXPECT_FALSE(background.motions[0].layers.empty());
  EXPECT_TRUE(background.motions[1].layers.empty());
}

TEST(ChooseAge, IsTheSame_ByWhicheverAgeIsFitted) {
  // Over two images the target differs by 3.2 px from what is behind it, which is enough and not
  // too much.
  for (const FittedAges ages : {FittedAges::kShorter, FittedAges::kLonger, FittedAges::kBoth}) {
    PointsState points = followed(kScene, 10);
    BackgroundState background;
    background.age = 2;
    ASSERT_TRUE(explain_background({}, 1, ages, &points, &background));
    choose_age(points, &background);
    EXPECT_EQ(background.age, 2U);
  }
}

}  // namespace
}  // namespace polhode::background_test
