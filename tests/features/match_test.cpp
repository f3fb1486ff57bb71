#include "features/match.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "base/rng.hpp"

namespace polhode::match_test {
namespace {

// As RootSIFT makes them: bytes of norm 512, unrelated ones some 500 to 600 apart.
Descriptor random_descriptor(Rng* rng) {
  std::array<double, 128> values{};
  double sum = 0.0;
  for (double& v : values) {
    v = std::pow(std::log(1.0 - rng->uniform()), 2);
    sum += v;
  }
  Descriptor d;
  for (std::size_t i = 0; i < d.size(); ++i) {
    d[i] = static_cast<std::uint8_t>(std::min(255.0, 512.0 * std::sqrt(values[i] / sum)));
  }
  return d;
}

Descriptor disturbed(const Descriptor& from, double sigma, Rng* rng) {
  Descriptor d;
  for (std::size_t i = 0; i < d.size(); ++i) {
    d[i] = static_cast<std::uint8_t>(std::clamp(from[i] + sigma * rng->normal(), 0.0, 255.0));
  }
  return d;
}

Feature feature_at(double u_px, double v_px, const Descriptor& descriptor) {
  Feature f;
  f.u_px = static_cast<float>(u_px);
  f.v_px = static_cast<float>(v_px);
  f.descriptor = descriptor;
  return f;
}

std::vector<Feature> random_features(int count, double width_px, double height_px, Rng* rng) {
  std::vector<Feature> features;
  for (int i = 0; i < count; ++i) {
    features.push_back(
        feature_at(width_px * rng->uniform(), height_px * rng->uniform(), random_descriptor(rng)));
  }
  return features;
}

TEST(Distance2, IsTheSquaredEuclideanDistance) {
  Descriptor a{};
  Descriptor b{};
  EXPECT_EQ(distance2(a, b), 0);
  b.fill(255);
  EXPECT_EQ(distance2(a, b), 128 * 255 * 255);
  a[0] = 255;
  EXPECT_EQ(distance2(a, b), 127 * 255 * 255);
  EXPECT_EQ(distance2(a, b), distance2(b, a));
}

TEST(FeatureGrid, FindsWhatASearchThroughAllFinds) {
  Rng rng(11, 0);
  constexpr int kWidth = 640;
  constexpr int kHeight = 480;
  const std::vector<Feature> features = random_features(700, kWidth, kHeight, &rng);
  auto grid = std::make_unique<FeatureGrid>();
  grid->build(features, kWidth, kHeight);
  for (int trial = 0; trial < 200; ++trial) {
    // Also about places outside the image, where predictions may fall.
    const double u = -50.0 + (kWidth + 100.0) * rng.uniform();
    const double v = -50.0 + (kHeight + 100.0) * rng.uniform();
    const double radius = 60.0 * rng.uniform();
    std::vector<std::int32_t> expected;
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (std::hypot(static_cast<double>(features[i].u_px) - u,
                     static_cast<double>(features[i].v_px) - v) <= radius) {
        expected.push_back(static_cast<std::int32_t>(i));
      }
    }
    std::vector<std::int32_t> found(features.size());
    found.resize(grid->find(u, v, radius, found));
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected) << "trial " << trial;
  }
}

TEST(FeatureGrid, FindsFeaturesOnTheEdgesOfTheImage) {
  const std::vector<Feature> features{feature_at(0, 0, {}),
                                      feature_at(639.4, 0, {}),
                                      feature_at(0, 479.4, {}),
                                      feature_at(639.4, 479.4, {})};
  auto grid = std::make_unique<FeatureGrid>();
  grid->build(features, 640, 480);
  for (std::size_t i = 0; i < features.size(); ++i) {
    std::array<std::int32_t, 4> found{};
    ASSERT_EQ(grid->find(features[i].u_px, features[i].v_px, 1.0, found), 1U);
    EXPECT_EQ(found[0], static_cast<std::int32_t>(i));
  }
}

TEST(FeatureGrid, StopsWhenTheAnswerIsFull) {
  Rng rng(12, 0);
  const std::vector<Feature> features = random_features(100, 20.0, 20.0, &rng);
  auto grid = std::make_unique<FeatureGrid>();
  grid->build(features, 640, 480);
  std::array<std::int32_t, 5> found{};
  EXPECT_EQ(grid->find(10.0, 10.0, 100.0, found), 5U);
}

TEST(FeatureGrid, FindsNothing_AmongNoFeatures) {
  auto grid = std::make_unique<FeatureGrid>();
  grid->build({}, 640, 480);
  std::array<std::int32_t, 5> found{};
  EXPECT_EQ(grid->find(10.0, 10.0, 1000.0, found), 0U);
}

/// The rule as written: mutual best, and best against the second best at another place, on both
/// sides.
std::vector<std::pair<int, int>> brute_force(const std::vector<Feature>& a,
                                             const std::vector<Feature>& b,
                                             double ratio_max) {
  const auto place_apart = [](const Feature& p, const Feature& q) {
    return std::hypot(p.u_px - q.u_px, p.v_px - q.v_px) >= 2.0F;
  };
  const auto best = [&](const Feature& wanted, const std::vector<Feature>& among) {
    std::size_t nearest = 0;
    for (std::size_t j = 1; j < among.size(); ++j) {
      if (distance2(wanted.descriptor, among[j].descriptor) <
          distance2(wanted.descriptor, among[nearest].descriptor)) {
        nearest = j;
      }
    }
    double rival = 1e18;
    for (const Feature& other : among) {
      if (place_apart(other, among[nearest])) {
        rival =
            std::min(rival, static_cast<double>(distance2(wanted.descriptor, other.descriptor)));
      }
    }
    const double d2 = distance2(wanted.descriptor, among[nearest].descriptor);
    const bool clear = d2 <= ratio_max * ratio_max * rival && d2 <= kDistance2Max;
    return std::pair<std::size_t, bool>{nearest, clear};
  };
  std::vector<std::pair<int, int>> matches;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto [j, clear] = best(a[i], b);
    const auto [back, clear_back] = best(b[j], a);
    if (clear && clear_back && !place_apart(a[back], a[i])) {
      matches.emplace_back(static_cast<int>(i), static_cast<int>(j));
    }
  }
  return matches;
}

TEST(MatchMutual, FindsWhatASearchThroughAllFinds) {
  auto matches = std::make_unique<FeatureMatches>();
  std::size_t total = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Rng rng(seed, 13);
    // Places on a grid of 10 px: either the same or far apart, so that "the same place" is an
    // equivalence.
    std::vector<Feature> a;
    for (int i = 0; i < 60; ++i) {
      a.push_back(feature_at(10.0 * (i / 2), 10.0 * (i % 3), random_descriptor(&rng)));
    }
    std::vector<Feature> b;
    for (int i = 0; i < 80; ++i) {
      const bool related = rng.uniform() < 0.6;
      // From nearly equal to hardly alike, some twice: each gate is met from both sides.
      const Descriptor d =
          related ? disturbed(a[rng.below(60)].descriptor, 5.0 + 35.0 * rng.uniform(), &rng)
                  : random_descriptor(&rng);
      b.push_back(feature_at(10.0 * (i / 2), 10.0 * (i % 5), d));
    }
    match_mutual(a, b, 0.8, matches.get());
    std::vector<std::pair<int, int>> found;
    for (const FeatureMatch& m : *matches) {
      found.emplace_back(m.a, m.b);
      EXPECT_EQ(m.distance2,
                distance2(a[static_cast<std::size_t>(m.a)].descriptor,
                          b[static_cast<std::size_t>(m.b)].descriptor));
    }
    EXPECT_EQ(found, brute_force(a, b, 0.8)) << "seed " << seed;
    total += found.size();
  }
  EXPECT_GT(total, 100U) << "the comparison would be empty";
}

TEST(MatchMutual, RefusesASpotThatLooksLikeTwoPlaces) {
  Rng rng(14, 0);
  const Descriptor cell = random_descriptor(&rng);
  const std::vector<Feature> a{feature_at(10, 10, cell)};
  const std::vector<Feature> b{feature_at(10, 10, disturbed(cell, 3.0, &rng)),
                               feature_at(60, 10, disturbed(cell, 3.0, &rng))};
  auto matches = std::make_unique<FeatureMatches>();
  match_mutual(a, b, 0.8, matches.get());
  EXPECT_TRUE(matches->empty());
  match_mutual(b, a, 0.8, matches.get());
  EXPECT_TRUE(matches->empty());
}

TEST(MatchMutual, TakesASpotWithTwoOrientations) {
  Rng rng(15, 0);
  const Descriptor spot = random_descriptor(&rng);
  const std::vector<Feature> a{feature_at(10, 10, spot)};
  const std::vector<Feature> b{feature_at(30, 10, disturbed(spot, 3.0, &rng)),
                               feature_at(30, 10, disturbed(spot, 3.0, &rng))};
  auto matches = std::make_unique<FeatureMatches>();
  match_mutual(a, b, 0.8, matches.get());
  EXPECT_EQ(matches->size(), 1U);
}

TEST(MatchMutual, FindsNothing_WhereNothingIsAlike) {
  Rng rng(16, 0);
  const std::vector<Feature> a = random_features(50, 640.0, 480.0, &rng);
  const std::vector<Feature> b = random_features(50, 640.0, 480.0, &rng);
  auto matches = std::make_unique<FeatureMatches>();
  match_mutual(a, b, 0.8, matches.get());
  EXPECT_TRUE(matches->empty());
  match_mutual(a, {}, 0.8, matches.get());
  EXPECT_TRUE(matches->empty());
  match_mutual({}, b, 0.8, matches.get());
  EXPECT_TRUE(matches->empty());
}

}  // namespace
}  // namespace polhode::match_test
