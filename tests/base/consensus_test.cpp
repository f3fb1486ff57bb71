#include "base/consensus.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "base/fixed_vector.hpp"

namespace polhode::consensus_test {
namespace {

TEST(DrawsNeeded, LeaveNoMoreThanTheChanceThatIsAskedFor) {
  for (const int points : {3, 4}) {
    for (const double inliers : {0.1, 0.3, 0.5, 0.8}) {
      for (const double missed : {1e-2, 1e-3}) {
        const double spoilt = 1.0 - std::pow(inliers, points);
        const int draws = draws_needed(inliers, points, missed);
        EXPECT_LE(std::pow(spoilt, draws), missed);
        EXPECT_GT(std::pow(spoilt, draws - 1), missed);
      }
    }
  }
}

TEST(DrawsNeeded, IsOne_WhereAllAreInliers_AndFinite_WhereNoneIs) {
  EXPECT_EQ(draws_needed(1.0, 3, 1e-2), 1);
  EXPECT_GT(draws_needed(0.0, 3, 1e-2), 100'000'000);
  EXPECT_EQ(draws_needed(-1e300, 3, 1e-2), draws_needed(0.0, 3, 1e-2));
  EXPECT_GT(draws_needed(0.0, 9, 1e-9), draws_needed(0.0, 9, 1e-2));
}

template <std::size_t kPoints>
void expect_distinct_below(std::size_t count) {
  Rng rng(3, count);
  for (int draw = 0; draw < 300; ++draw) {
    const Sample<kPoints> sample = draw_sample<kPoints>(count, &rng);
    EXPECT_EQ(std::set<std::size_t>(sample.begin(), sample.end()).size(), kPoints);
    EXPECT_LT(*std::max_element(sample.begin(), sample.end()), count);
  }
}

TEST(DrawSample, NeverRepeats) {
  expect_distinct_below<2>(2);
  expect_distinct_below<5>(5);
  expect_distinct_below<5>(6);
  expect_distinct_below<4>(1000);
}

TEST(DrawSample, GivesEveryOrderedSampleAlikeOften) {
  constexpr std::size_t kCount = 9;
  constexpr int kDraws = 100'800;  // 200 of each of 9 * 8 * 7 ordered samples
  std::vector<int> seen(kCount * kCount * kCount);
  Rng rng(11, 0);
  for (int i = 0; i < kDraws; ++i) {
    const Sample<3> s = draw_sample<3>(kCount, &rng);
    ++seen[(s[0] * kCount + s[1]) * kCount + s[2]];
  }
  const double expected = kDraws / 504.0;
  double chi2 = 0.0;
  int kinds = 0;
  for (const int n : seen) {
    kinds += n > 0 ? 1 : 0;
    chi2 += n > 0 ? (n - expected) * (n - expected) / expected : 0.0;
  }
  EXPECT_EQ(kinds, 504);
  // 503 degrees of freedom: mean 503, deviation sqrt(2 * 503) = 32. Within four of these.
  EXPECT_LT(chi2, 503.0 + 4.0 * 32.0);
  EXPECT_GT(chi2, 503.0 - 4.0 * 32.0);
}

TEST(DrawSample, TakesAsManyNumbersAsPoints) {
  Rng sampled(1, 2);
  Rng counted(1, 2);
  (void)draw_sample<4>(4, &sampled);
  for (int i = 0; i < 4; ++i) {
    (void)counted.next();
  }
  EXPECT_EQ(sampled.next(), counted.next());
}

// A line y = slope x + offset, through two points.
struct Line {
  double slope = 0.0;
  double offset = 0.0;
};

constexpr Line kTruth{.slope = 0.5, .offset = 2.0};

struct Scene {
  std::vector<double> x;
  std::vector<double> y;

  /// Inliers lie on the line but for rounding, outliers within 10 of it.
  Scene(int inliers, int outliers, std::uint64_t seed) {
    Rng rng(seed, 77);
    for (int i = 0; i < inliers + outliers; ++i) {
      x.push_back(i + 0.5 * rng.uniform());
      const double off = 0.1 + 9.9 * rng.uniform();
      y.push_back(kTruth.slope * x.back() + kTruth.offset + (i < inliers ? 0.0 : off));
    }
  }
  [[nodiscard]] std::optional<Line> through(const Sample<2>& s) const {
    const double slope = (y[s[1]] - y[s[0]]) / (x[s[1]] - x[s[0]]);
    return Line{.slope = slope, .offset = y[s[0]] - slope * x[s[0]]};
  }
  /// Points off the line.
  [[nodiscard]] double score(const Line& line) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      sum += std::abs(line.slope * x[i] + line.offset - y[i]) > 1e-9 ? 1.0 : 0.0;
    }
    return sum;
  }
};

struct Found {
  BestHypothesis<Line> best;
  int draws = 0;

  [[nodiscard]] bool right() const { return std::abs(best.model.slope - kTruth.slope) < 1e-9; }
};

Found find_line(const Scene& scene, int draws_max, double missed, std::uint64_t seed) {
  Found found;
  find_consensus<2>(
      {.points = scene.x.size(),
       .draws_max = draws_max,
       .seed = seed,
       .stream = 5,
       .missed = missed,
       .score_of_none = static_cast<double>(scene.x.size())},
      [&](const Sample<2>& sample) {
        ++found.draws;
        return scene.through(sample);
      },
      [&](const Line* line, double) { return scene.score(*line); },
      &found.best);
  return found;
}

TEST(FindConsensus, MissesHalfOfOutliersAsRarelyAsPromised) {
  const Scene scene(100, 100, 1);
  constexpr double kMissed = 0.05;
  constexpr int kRuns = 4000;
  const int draws = draws_needed(0.5, 2, kMissed);
  int misses = 0;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    misses += find_line(scene, draws, 0.0, seed).right() ? 0 : 1;
  }
  // A pair holds inliers only with 100 / 200 * 99 / 199; each draw is made again.
  const double expected = kRuns * std::pow(1.0 - 100.0 * 99.0 / (200.0 * 199.0), draws);
  EXPECT_NEAR(misses, expected, 4.0 * std::sqrt(expected));
  EXPECT_LT(misses, kMissed * kRuns);
}

TEST(FindConsensus, StopsEarly_OnceItHasDrawnEnough) {
  const Scene scene(60, 40, 2);
  int draws = 0;
  int misses = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const Found found = find_line(scene, 1000, 1e-2, seed);
    misses += found.right() ? 0 : 1;
    draws += found.draws;
    EXPECT_GE(found.draws, draws_needed(0.6, 2, 1e-2));
  }
  EXPECT_LE(misses, 500 / 100);
  EXPECT_LT(draws, 500 * 20);
  EXPECT_EQ(find_line(scene, 1000, 0.0, 1).draws, 1000);
  EXPECT_EQ(find_line(Scene(50, 0, 3), 1000, 1e-2, 1).draws, 1);
  EXPECT_EQ(find_line(Scene(0, 50, 3), 1000, 1e-2, 1).draws, 1000);
}

TEST(FindConsensus, DependsOnSeedAndStreamAlone) {
  const Scene scene(10, 90, 4);
  const Found a = find_line(scene, 8, 0.0, 1);
  (void)find_line(scene, 30, 0.0, 2);
  const Found b = find_line(scene, 8, 0.0, 1);
  EXPECT_EQ(a.best.score, b.best.score);
  EXPECT_EQ(a.best.model.slope, b.best.model.slope);
  EXPECT_NE(a.best.model.slope, find_line(scene, 8, 0.0, 2).best.model.slope);
}

TEST(FindConsensus, GivesNone_FromTooFewPoints_NoDraws_OrNoHypothesis) {
  EXPECT_FALSE(find_line(Scene(1, 0, 5), 10, 0.0, 1).best.found());
  EXPECT_FALSE(find_line(Scene(0, 0, 5), 10, 0.0, 1).best.found());
  EXPECT_FALSE(find_line(Scene(20, 0, 5), 0, 0.0, 1).best.found());
  BestHypothesis<Line> best;
  find_consensus<2>(
      {.points = 9, .draws_max = 5},
      [](const Sample<2>&) { return std::optional<Line>(); },
      [](const Line*, double) { return 0.0; },
      &best);
  EXPECT_FALSE(best.found());
}

TEST(FindConsensus, TakesTheBestOfAllThatASampleGives_AndWhatScoringMadeOfIt) {
  BestHypothesis<int> best;
  find_consensus<1>(
      {.points = 3, .draws_max = 20},
      [](const Sample<1>& s) {
        FixedVector<int, 3> several;
        for (int k = 0; k < 3; ++k) {
          (void)several.push_back(static_cast<int>(10 * s[0]) + k);
        }
        return several;
      },
      [](int* value, double) {
        const double score = std::abs(*value - 11);
        *value += 100;
        return score;
      },
      &best);
  EXPECT_EQ(best.model, 111);
  EXPECT_EQ(best.score, 0.0);
}

TEST(FindConsensus, LeavesWhatItCannotBeat_AndRefusesScoresThatAreNoNumbers) {
  BestHypothesis<int> best{.model = -1, .score = 2.0};
  const auto fit = [](const Sample<1>&) { return std::optional(7); };
  find_consensus<1>(
      {.points = 3, .draws_max = 5}, fit, [](int*, double) { return 2.0; }, &best);
  EXPECT_EQ(best.model, -1);
  find_consensus<1>(
      {.points = 3, .draws_max = 5}, fit, [](int*, double) { return std::nan(""); }, &best);
  EXPECT_EQ(best.model, -1);
  find_consensus<1>(
      {.points = 3, .draws_max = 5}, fit, [](int*, double) { return 1.0; }, &best);
  EXPECT_EQ(best.model, 7);
}

/// The two least of what is offered.
struct TwoLeast {
  FixedVector<double, 2> list;

  [[nodiscard]] double bound() const { return list.full() ? list.back() : kNoScore; }
  void keep(int /*model*/, double score) {
    if (list.full()) {
      list.pop_back();
    }
    (void)list.push_back(score);
    if (list.full() && list[1] < list[0]) {
      std::swap(list[0], list[1]);
    }
  }
};

TEST(FindConsensus, LetsTheCallerKeepSeveral) {
  TwoLeast best;
  find_consensus<1>(
      {.points = 8, .draws_max = 200},
      [](const Sample<1>& s) { return std::optional(static_cast<int>(s[0])); },
      [](const int* value, double) { return static_cast<double>(*value); },
      &best);
  EXPECT_EQ(best.list[0], 0.0);
  EXPECT_EQ(best.list[1], 0.0);
}

}  // namespace
}  // namespace polhode::consensus_test
