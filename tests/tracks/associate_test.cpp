// Two images of a body whose motion is known: an affine one of all, and what its depth adds.
#include "tracks/associate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "base/rng.hpp"

namespace polhode::associate_test {
namespace {

constexpr double kRatioMax = 0.8;
constexpr int kSpots = 200;

/// The look of spot `spot`: of norm near 512, any two some 512 apart.
Descriptor look_of(int spot) {
  Rng rng(43, static_cast<std::uint64_t>(spot));
  Descriptor d;
  for (std::uint8_t& byte : d) {
    byte = static_cast<std::uint8_t>(rng.below(2) * 64);
  }
  return d;
}

/// The same look from elsewhere: a hundred bytes that are off by `step`.
Descriptor changed(Descriptor look, int step) {
  for (std::size_t i = 0; i < 100; ++i) {
    look[i] = static_cast<std::uint8_t>(look[i] + step);
  }
  return look;
}

Feature feature_at(const Eigen::Vector2d& at, const Descriptor& look) {
  Feature f;
  f.u_px = static_cast<float>(at.x());
  f.v_px = static_cast<float>(at.y());
  f.descriptor = look;
  return f;
}

struct Body {
  Eigen::Vector2d middle{400.0, 300.0};
  double bulge_px = 3.0;  ///< that its middle moves more than its rim
};

/// A rotation by 6 deg, 2 % of approach, a shift, and what a bulging body of radius 150 px adds.
Eigen::Vector2d moved(const Eigen::Vector2d& at, const Body& body) {
  constexpr double kTurn_rad = 0.105;
  Eigen::Matrix2d turn;
  turn << std::cos(kTurn_rad), -std::sin(kTurn_rad), std::sin(kTurn_rad), std::cos(kTurn_rad);
  const Eigen::Vector2d from = at - body.middle;
  const double bulge = 1.0 - from.squaredNorm() / (150.0 * 150.0);
  return body.middle + 1.02 * turn * from + Eigen::Vector2d(12.0 + body.bulge_px * bulge, -7.0);
}

/// Spot i is feature i of both, and looks a little different in `b`.
struct TwoFrames {
  std::vector<Feature> a;
  std::vector<Feature> b;

  explicit TwoFrames(int spots = kSpots, double noise_px = 0.0, const Body& body = {}) {
    Rng rng(44, 0);
    for (int i = 0; i < spots; ++i) {
      // A sunflower's seeds: evenly spread over a disc, some 19 px apart.
      const double angle = 2.39996 * i;
      const double radius = 150.0 * std::sqrt((i + 0.5) / spots);
      const Eigen::Vector2d at =
          body.middle + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      a.push_back(feature_at(at, look_of(i)));
      const Eigen::Vector2d noise(rng.normal(), rng.normal());
      b.push_back(feature_at(moved(at, body) + noise_px * noise, changed(look_of(i), 5)));
    }
  }
  /// Spots i and j look alike: their looks alone do not distinguish them.
  void make_alike(int i, int j) {
    a[static_cast<std::size_t>(j)].descriptor = a[static_cast<std::size_t>(i)].descriptor;
    b[static_cast<std::size_t>(j)].descriptor = b[static_cast<std::size_t>(i)].descriptor;
  }
  void shift_in_b(int i, float by_u_px, float by_v_px) {
    b[static_cast<std::size_t>(i)].u_px += by_u_px;
    b[static_cast<std::size_t>(i)].v_px += by_v_px;
  }
};

FeatureMatches by_looks(const TwoFrames& f) {
  FeatureMatches matches;
  match_mutual(f.a, f.b, kRatioMax, &matches);
  return matches;
}

FeatureMatches associated(const TwoFrames& f) {
  FeatureMatches matches;
  associate(f.a, f.b, kRatioMax, &matches);
  return matches;
}

/// The feature of `b` that is associated to feature `a`, or -1.
int partner_of(int a, const FeatureMatches& matches) {
  const auto* const at =
      std::find_if(matches.begin(), matches.end(), [a](const FeatureMatch& m) { return m.a == a; });
  return at == matches.end() ? -1 : at->b;
}

void expect_ascending_one_to_one(const FeatureMatches& matches) {
  std::set<int> taken;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    EXPECT_TRUE(taken.insert(matches[i].b).second) << "a feature of b twice";
    if (i > 0) {
      EXPECT_LT(matches[i - 1].a, matches[i].a);
    }
  }
}

TEST(Associate, KeepsTheMatchesOfABodyThatTurns) {
  const FeatureMatches matches = associated(TwoFrames(kSpots, 0.2));
  ASSERT_EQ(matches.size(), static_cast<std::size_t>(kSpots));
  for (const FeatureMatch& m : matches) {
    EXPECT_EQ(m.a, m.b);
  }
}

TEST(Associate, GivesTheSame_WhereverTheBodyIsInTheImage) {
  // A bulge and noise such that some matches at the rim are suspect.
  const Body here{.bulge_px = 5.0};
  const FeatureMatches expected = associated(TwoFrames(kSpots, 0.3, here));
  EXPECT_GT(expected.size(), 9U * kSpots / 10U);
  for (const double far_px : {500.0, 1500.0}) {
    Body there = here;
    there.middle += Eigen::Vector2d(far_px, 0.6 * far_px);
    const FeatureMatches matches = associated(TwoFrames(kSpots, 0.3, there));
    ASSERT_EQ(matches.size(), expected.size()) << far_px;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      EXPECT_EQ(matches[i].a, expected[i].a) << far_px;
    }
  }
}

TEST(Associate, DropsAMatchThatMovesOtherwiseThanItsNeighbours) {
  TwoFrames f(kSpots, 0.2);
  const std::vector<int> strays{3, 60, 61, 150, 199};
  for (const int i : strays) {
    f.shift_in_b(i, 9.0F, -7.0F);
  }
  const FeatureMatches before = by_looks(f);
  const FeatureMatches after = associated(f);
  EXPECT_EQ(after.size(), kSpots - strays.size());
  for (const int i : strays) {
    EXPECT_EQ(partner_of(i, before), i) << "its look alone says nothing against it";
    EXPECT_EQ(partner_of(i, after), -1) << i;
  }
}

// verifies: TRK-03
TEST(Associate, IsNotMisled_WhenAFifthOfTheMatchesIsWrong) {
  TwoFrames f(kSpots, 0.2);
  for (int i = 0; i < kSpots; i += 5) {
    f.shift_in_b(i, 80.0F - static_cast<float>(i), static_cast<float>(i) - 110.0F);
  }
  const FeatureMatches matches = associated(f);
  int wrong = 0;
  int right = 0;
  for (const FeatureMatch& m : matches) {
    (m.a % 5 == 0 ? wrong : right) += 1;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_GE(right, 9 * kSpots * 4 / 50) << "nine tenths of the right ones";
}

TEST(Associate, FindsFeaturesThatLookAlike_WhereTheirNeighboursWent) {
  TwoFrames f(kSpots, 0.2);
  f.make_alike(20, 140);
  f.make_alike(77, 33);
  const FeatureMatches before = by_looks(f);
  const FeatureMatches after = associated(f);
  for (const int i : {20, 140, 77, 33}) {
    EXPECT_EQ(partner_of(i, before), -1) << i;
    EXPECT_EQ(partner_of(i, after), i);
  }
  EXPECT_EQ(after.size(), static_cast<std::size_t>(kSpots));
  expect_ascending_one_to_one(after);
}

TEST(Associate, FindsNothing_WhereNoFeatureOfTheLookIs) {
  TwoFrames f;
  f.make_alike(20, 140);
  f.shift_in_b(20, 6.0F, 6.0F);  // no neighbour within 6 px of where it is expected
  const FeatureMatches matches = associated(f);
  EXPECT_EQ(partner_of(20, matches), -1);
  EXPECT_EQ(partner_of(140, matches), 140);
}

TEST(Associate, FindsAFeatureThatHasChanged_UnlessItHasChangedTooMuch) {
  TwoFrames f;
  f.make_alike(20, 140);
  f.b[20].descriptor = changed(f.a[20].descriptor, 25);    // 250 from its look in `a`
  f.b[140].descriptor = changed(f.a[140].descriptor, 30);  // 300
  const FeatureMatches matches = associated(f);
  EXPECT_EQ(partner_of(20, matches), 20);
  EXPECT_EQ(partner_of(140, matches), -1);
}

TEST(Associate, DoesNotMatchAlikeFeaturesBesideEachOther) {
  TwoFrames f;
  const Feature alone = f.b[50];
  f.shift_in_b(50, -0.6F, 0.0F);
  f.b.push_back(alone);
  f.b.back().u_px += 0.6F;
  EXPECT_EQ(partner_of(50, associated(f)), -1) << "either may be it";
  f.b.back().u_px = f.b[50].u_px;
  EXPECT_NE(partner_of(50, associated(f)), -1) << "two orientations of one blob";
}

TEST(Associate, GivesAFeatureToTheOneThatLooksMostLikeIt) {
  TwoFrames f;
  f.make_alike(20, 140);
  // A second spot beside 20 in `a` that is not seen in `b`, and looks a little less like it.
  f.a.push_back(
      feature_at({static_cast<double>(f.a[20].u_px) + 1.2, static_cast<double>(f.a[20].v_px)},
                 changed(f.a[20].descriptor, 20)));
  const FeatureMatches matches = associated(f);
  EXPECT_EQ(partner_of(20, matches), 20);
  EXPECT_EQ(partner_of(kSpots, matches), -1);
  expect_ascending_one_to_one(matches);
}

TEST(Associate, LeavesFewMatchesAsTheyAre) {
  TwoFrames few(15);
  few.shift_in_b(7, 40.0F, 40.0F);
  const FeatureMatches mutual = by_looks(few);
  const FeatureMatches kept = associated(few);
  ASSERT_EQ(kept.size(), 15U);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept[i].a, mutual[i].a);
    EXPECT_EQ(kept[i].b, mutual[i].b);
  }
  TwoFrames enough(16);
  enough.shift_in_b(7, 90.0F, 90.0F);
  EXPECT_EQ(partner_of(7, associated(enough)), -1);
}

TEST(Associate, LeavesMatchesAsTheyAre_WhereNeighboursHaveNoMotionInCommon) {
  TwoFrames f;
  Rng rng(45, 0);
  for (int i = 0; i < kSpots; ++i) {  // by as much as the body is large
    f.shift_in_b(
        i, 150.0F * static_cast<float>(rng.normal()), 150.0F * static_cast<float>(rng.normal()));
  }
  f.make_alike(20, 140);  // not looked for either: no neighbour indicates where
  const FeatureMatches mutual = by_looks(f);
  const FeatureMatches kept = associated(f);
  ASSERT_EQ(kept.size(), static_cast<std::size_t>(kSpots) - 2U);
  ASSERT_EQ(kept.size(), mutual.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(kept[i].a, mutual[i].a);
    EXPECT_EQ(kept[i].b, mutual[i].b);
  }
}

TEST(Associate, FindsNothing_InEmptyFrames) {
  FeatureMatches matches;
  associate({}, {}, kRatioMax, &matches);
  EXPECT_TRUE(matches.empty());
  const TwoFrames f;
  associate(f.a, {}, kRatioMax, &matches);
  EXPECT_TRUE(matches.empty());
}

TEST(Associate, StaysFinite_WhereAllFeaturesLieInOneLineOrPlace) {
  for (const double step_px : {0.0, 4.0}) {
    TwoFrames f;
    for (int i = 0; i < kSpots; ++i) {
      const Eigen::Vector2d at(100.0 + step_px * i, 50.0 + 0.5 * step_px * i);
      f.a[static_cast<std::size_t>(i)] = feature_at(at, look_of(i));
      f.b[static_cast<std::size_t>(i)] = feature_at(at + Eigen::Vector2d(5.0, 3.0), look_of(i));
    }
    EXPECT_EQ(associated(f).size(), static_cast<std::size_t>(kSpots)) << step_px;
  }
}

/// Spots that come and go, alike ones, noise and clutter.
TwoFrames disorder() {
  TwoFrames f(kSpots, 0.4);
  Rng rng(45, 0);
  for (int i = 0; i < 30; ++i) {
    f.make_alike(static_cast<int>(rng.below(kSpots)), static_cast<int>(rng.below(kSpots)));
    f.shift_in_b(static_cast<int>(rng.below(kSpots)), 20.0F, -20.0F);
    f.a.push_back(feature_at({800.0 * rng.uniform(), 600.0 * rng.uniform()}, look_of(1000 + i)));
    f.b.push_back(feature_at({800.0 * rng.uniform(), 600.0 * rng.uniform()}, look_of(2000 + i)));
    f.b[rng.below(kSpots)].descriptor = look_of(3000 + i);
  }
  return f;
}

TEST(Associate, TiesOneToOneInOrder_WhateverComes) {
  const FeatureMatches matches = associated(disorder());
  EXPECT_GT(matches.size(), static_cast<std::size_t>(kSpots) / 2);
  expect_ascending_one_to_one(matches);
  for (const FeatureMatch& m : matches) {
    EXPECT_LT(m.a, kSpots) << "clutter";
    EXPECT_LT(m.b, kSpots) << "clutter";
  }
}

TEST(Associate, GivesTheSame_EachTime) {
  const TwoFrames f = disorder();
  const FeatureMatches once = associated(f);
  (void)associated(TwoFrames(40));
  const FeatureMatches again = associated(f);
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(once[i].a, again[i].a);
    EXPECT_EQ(once[i].b, again[i].b);
    EXPECT_EQ(once[i].distance2, again[i].distance2);
  }
}

}  // namespace
}  // namespace polhode::associate_test
