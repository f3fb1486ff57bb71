// Median of a list, and medians of normal noise.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "base/assert.hpp"

namespace polhode {

// Medians of chi-square with two and three degrees of freedom.
inline constexpr double kChi2Median2 = 1.3863;
inline constexpr double kChi2Median3 = 2.366;

// Standard deviation of normal noise over its median absolute deviation.
inline constexpr double kSigmaPerMad = 1.4826;

/// Element `rank` of the sorted list. The list's order is changed.
/// @pre rank < values.size()
template <typename T>
T ranked(std::span<T> values, std::size_t rank) {
  POLHODE_ASSERT(rank < values.size(), rank);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Of an even number the upper of the middle two; 0 of an empty list. The list's order is changed.
template <typename T>
T median(std::span<T> values) {
  return values.empty() ? T{} : ranked(values, values.size() / 2);
}

}  // namespace polhode
