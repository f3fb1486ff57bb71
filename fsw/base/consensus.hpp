// Consensus of random samples (RANSAC): one sampler and one loop for every model.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "base/assert.hpp"
#include "base/rng.hpp"

namespace polhode {

/// Worse than any score.
inline constexpr double kNoScore = 1e300;

/// Draws after which, but for a probability of `missed`, one had inliers only.
/// @param inliers  share of inliers, 0 .. 1
/// @param points   points of a draw
/// @param missed   from 1e-9 to 1
/// @source Fischler and Bolles, CACM 1981.
inline int draws_needed(double inliers, int points, double missed) {
  // The number of draws still fits an int where one in 1e9 may be missed.
  constexpr double kAllInliersMin = 1e-8;
  // Keeps the logarithm finite: at least one draw.
  constexpr double kAllInliersMax = 0.999;
  const double all_inliers =
      std::clamp(std::pow(std::max(0.0, inliers), static_cast<double>(points)),
                 kAllInliersMin,
                 kAllInliersMax);
  return static_cast<int>(std::ceil(std::log(missed) / std::log(1.0 - all_inliers)));
}

/// Different indices, in the order drawn.
template <std::size_t kPoints>
using Sample = std::array<std::size_t, kPoints>;

/// Indices below `count`, without replacement: each ordered sample is as likely as any other.
/// Always takes kPoints random numbers.
/// @pre kPoints <= count
template <std::size_t kPoints>
Sample<kPoints> draw_sample(std::size_t count, Rng* rng) {
  POLHODE_ASSERT(kPoints <= count, count);
  Sample<kPoints> sample{};
  Sample<kPoints> ascending{};
  for (std::size_t i = 0; i < kPoints; ++i) {
    std::size_t index = rng->below(static_cast<std::uint32_t>(count - i));
    // Maps the draw to an index that was not drawn before, and inserts it in ascending order.
    std::size_t place = 0;
    for (; place < i && index >= ascending[place]; ++place) {
      ++index;
    }
    for (std::size_t k = i; k > place; --k) {
      ascending[k] = ascending[k - 1];
    }
    ascending[place] = index;
    sample[i] = index;
  }
  return sample;
}

struct ConsensusSearch {
  std::size_t points = 0;  ///< to draw from
  int draws_max = 0;
  std::uint64_t seed = 0;
  std::uint64_t stream = 0;  ///< of the random numbers
  /// Probability that no sample had inliers only when the search ends early. 0: all draws are made.
  double missed = 0.0;
  /// Score of a hypothesis that no point agrees with, where the search may end early. Every
  /// outlier adds its part of that, so the score bounds the number of outliers.
  double score_of_none = 1.0;
};

/// Keeps one hypothesis. Another class in its place in find_consensus() may keep several.
template <typename Model>
struct BestHypothesis {
  Model model{};
  double score = kNoScore;

  [[nodiscard]] bool found() const { return score < kNoScore; }
  /// Only a score below this is kept.
  [[nodiscard]] double bound() const { return score; }
  void keep(const Model& better, double its_score) {
    model = better;
    score = its_score;
  }
};

/// Keeps a hypothesis that scores better than those before.
/// @param score  as in find_consensus.
template <typename Model, typename Score, typename Best>
void consider(Model hypothesis, const Score& score, Best* best) {
  const double its_score = score(&hypothesis, best->bound());
  if (its_score < best->bound()) {
    best->keep(hypothesis, its_score);
  }
}

/// The hypotheses of a fit as a range: those of a list, or of an optional.
template <typename List>
const List& listed(const List& several) {
  return several;
}
template <typename Model>
std::span<const Model> listed(const std::optional<Model>& one) {
  return one ? std::span<const Model>(&*one, 1) : std::span<const Model>();
}

/// Draws samples, fits hypotheses to each, scores them and keeps the best. Nothing is kept where
/// there are fewer points than a sample has. No heap but that of `fit` and `score`.
/// @param fit    (Sample) -> the sample's hypotheses: an optional, or a list such as FixedVector.
/// @param score  (hypothesis*, bound) -> a number, smaller is better. It may stop at `bound` and
/// return anything from there on. It may also improve the hypothesis.
/// @param best   in, out: a BestHypothesis, or a class with its bound() and keep(). A hypothesis
/// kept on entry has to be beaten.
/// @cost  at most draws_max samples. Deterministic if `fit` and `score` are.
/// @source Fischler and Bolles, CACM 1981; end by the score so far: Torr and Zisserman 2000.
template <std::size_t kPoints, typename Fit, typename Score, typename Best>
void find_consensus(const ConsensusSearch& search, const Fit& fit, const Score& score, Best* best) {
  if (search.points < kPoints) {
    return;
  }
  Rng rng(search.seed, search.stream);
  int draws = search.draws_max;
  for (int i = 0; i < draws; ++i) {
    const auto hypotheses = fit(draw_sample<kPoints>(search.points, &rng));
    for (const auto& hypothesis : listed(hypotheses)) {
      consider(hypothesis, score, best);
    }
    if (search.missed > 0.0) {
      const double inliers = 1.0 - best->bound() / search.score_of_none;
      draws = std::min(search.draws_max,
                       draws_needed(inliers, static_cast<int>(kPoints), search.missed));
    }
  }
}

}  // namespace polhode
