// The middle of a list.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "base/assert.hpp"

namespace polhode {

/// The value that `rank` others are not above, as if the list were sorted; its order is changed.
/// @pre rank < values.size()
template <typename T>
T ranked(std::span<T> values, std::size_t rank) {
  POLHODE_ASSERT(rank < values.size(), rank);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The upper one of the two in the middle of an even number, 0 of none; the list's order is
/// changed.
template <typename T>
T median(std::span<T> values) {
  return values.empty() ? T{} : ranked(values, values.size() / 2);
}

}  // namespace polhode
