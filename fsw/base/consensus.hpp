// How many draws a RANSAC sampler needs.
#pragma once

#include <algorithm>
#include <cmath>

namespace polhode {

/// Draws after which, but for a probability of `missed`, one has held inliers only.
/// @param inliers  share of inliers, 0 .. 1
/// @param points   points of a draw
/// @source Fischler and Bolles, CACM 1981.
inline int draws_needed(double inliers, int points, double missed) {
  // The least share of inliers: with four points the number of draws still fits an int.
  constexpr double kInliersMin = 0.01;
  // Keeps the logarithm finite: at least one draw.
  constexpr double kAllInliersMax = 0.999;
  const double all_inliers =
      std::pow(std::clamp(inliers, kInliersMin, 1.0), static_cast<double>(points));
  return static_cast<int>(
      std::ceil(std::log(missed) / std::log(1.0 - std::min(all_inliers, kAllInliersMax))));
}

}  // namespace polhode
