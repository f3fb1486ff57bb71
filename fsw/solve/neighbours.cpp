#include "solve/neighbours.hpp"

#include <cstddef>
#include <limits>

#include "base/assert.hpp"
#include "base/avx2_dispatch.hpp"

namespace polhode {
namespace {

constexpr auto kColumns = static_cast<std::size_t>(kDescriptorBytes);

/// Squared distance; of constant length, so that it is vectorised.
int distance2(const std::uint8_t* a, const std::uint8_t* b) {
  int sum = 0;
  for (std::size_t i = 0; i < kColumns; ++i) {
    const int difference = static_cast<int>(a[i]) - static_cast<int>(b[i]);
    sum += difference * difference;
  }
  return sum;
}

/// Of equal distances the first row.
Neighbours nearest_two(std::span<const std::uint8_t> reference, const std::uint8_t* query) {
  int nearest2 = std::numeric_limits<int>::max();
  int second2 = std::numeric_limits<int>::max();
  Neighbours found;
  for (std::size_t row = 0; row * kColumns < reference.size(); ++row) {
    const int d2 = distance2(&reference[row * kColumns], query);
    if (d2 < nearest2) {
      found.second = found.nearest;
      second2 = nearest2;
      found.nearest = static_cast<std::int32_t>(row);
      nearest2 = d2;
    } else if (d2 < second2) {
      found.second = static_cast<std::int32_t>(row);
      second2 = d2;
    }
  }
  found.distance2_nearest = static_cast<float>(nearest2);
  found.distance2_second = found.second < 0 ? 0.0F : static_cast<float>(second2);
  return found;
}

}  // namespace

void nearest_descriptors(std::span<const std::uint8_t> reference,
                         std::span<const std::uint8_t> queries,
                         std::span<Neighbours> out) {
  POLHODE_ASSERT(reference.size() % kColumns == 0, reference.size());
  POLHODE_ASSERT(queries.size() == out.size() * kColumns, queries.size());
  if (reference.empty()) {
    return;
  }
  with_avx2([&] {
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = nearest_two(reference, &queries[i * kColumns]);
    }
  });
}

}  // namespace polhode
