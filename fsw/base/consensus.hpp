// How long a sampler has to go on drawing.
#pragma once

#include <algorithm>
#include <cmath>

namespace polhode {

/// Draws among which, but for a chance of `missed`, one holds inliers alone.
/// @param inliers  their share, 0 .. 1
/// @param points   of a draw
/// @source Fischler and Bolles, CACM 1981.
inline int draws_needed(double inliers, int points, double missed) {
  const double all_inliers = std::pow(std::clamp(inliers, 0.01, 1.0), static_cast<double>(points));
  return static_cast<int>(
      std::ceil(std::log(missed) / std::log(1.0 - std::min(all_inliers, 0.999))));
}

}  // namespace polhode
