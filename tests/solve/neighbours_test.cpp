#include "solve/neighbours.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/rng.hpp"

namespace polhode::neighbours_test {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr auto kRow = static_cast<std::size_t>(kDescriptorBytes);

Bytes random_rows(std::size_t rows, Rng* rng) {
  Bytes bytes(rows * kRow);
  for (std::uint8_t& o : bytes) {
    o = static_cast<std::uint8_t>(rng->below(120));
  }
  return bytes;
}

/// Rows of `reference`, each a little changed: as another view of the same spot.
Bytes views_of(const Bytes& reference,
               const std::vector<std::size_t>& rows,
               double sigma,
               Rng* rng) {
  Bytes bytes;
  for (const std::size_t row : rows) {
    for (std::size_t i = 0; i < kRow; ++i) {
      bytes.push_back(static_cast<std::uint8_t>(
          std::clamp(reference[row * kRow + i] + sigma * rng->normal(), 0.0, 255.0)));
    }
  }
  return bytes;
}

double distance2(const Bytes& a, std::size_t row_a, const Bytes& b, std::size_t row_b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < kRow; ++i) {
    sum += std::pow(
        static_cast<double>(a[row_a * kRow + i]) - static_cast<double>(b[row_b * kRow + i]), 2);
  }
  return sum;
}

std::vector<Neighbours> search(const Bytes& reference, const Bytes& queries) {
  std::vector<Neighbours> found(queries.size() / kRow);
  nearest_descriptors(reference, queries, found);
  return found;
}

TEST(NearestDescriptors, FindsTheSpot_OfWhichAQueryIsAnotherView) {
  Rng rng(71, 0);
  const Bytes reference = random_rows(2000, &rng);
  std::vector<std::size_t> rows;
  for (int i = 0; i < 300; ++i) {
    rows.push_back(rng.below(2000));
  }
  const Bytes queries = views_of(reference, rows, 10.0, &rng);
  const std::vector<Neighbours> found = search(reference, queries);
  int right = 0;
  for (std::size_t q = 0; q < rows.size(); ++q) {
    std::size_t nearest = 0;
    for (std::size_t r = 1; r < 2000; ++r) {
      nearest = distance2(queries, q, reference, r) < distance2(queries, q, reference, nearest)
                    ? r
                    : nearest;
    }
    ASSERT_EQ(nearest, rows[q]);
    right += found[q].nearest == static_cast<std::int32_t>(nearest) ? 1 : 0;
  }
  // The search looks at a bounded number of leaves, so some may be missed: relocalisation lives on
  // half of them.
  EXPECT_GE(right, 270);
}

TEST(NearestDescriptors, ReportsTrueDistances_NearestFirst) {
  Rng rng(72, 0);
  const Bytes reference = random_rows(500, &rng);
  const Bytes queries = random_rows(50, &rng);
  const std::vector<Neighbours> found = search(reference, queries);
  for (std::size_t q = 0; q < found.size(); ++q) {
    ASSERT_GE(found[q].nearest, 0);
    ASSERT_GE(found[q].second, 0);
    EXPECT_NE(found[q].nearest, found[q].second);
    EXPECT_LE(found[q].distance2_nearest, found[q].distance2_second);
    // Sums of squares of bytes are whole numbers under 2^24: exact in single precision.
    EXPECT_EQ(found[q].distance2_nearest,
              distance2(queries, q, reference, static_cast<std::size_t>(found[q].nearest)));
    EXPECT_EQ(found[q].distance2_second,
              distance2(queries, q, reference, static_cast<std::size_t>(found[q].second)));
  }
}

TEST(NearestDescriptors, IsExact_WhenThereAreFewReferences) {
  Rng rng(73, 0);
  const Bytes reference = random_rows(30, &rng);
  const Bytes queries = random_rows(40, &rng);
  const std::vector<Neighbours> found = search(reference, queries);
  for (std::size_t q = 0; q < found.size(); ++q) {
    double nearest = std::numeric_limits<double>::max();
    for (std::size_t r = 0; r < 30; ++r) {
      nearest = std::min(nearest, distance2(queries, q, reference, r));
    }
    EXPECT_EQ(found[q].distance2_nearest, nearest);
  }
}

TEST(NearestDescriptors, GivesTheSameAnswer_AfterOtherSearches) {
  Rng rng(74, 0);
  const Bytes reference = random_rows(1500, &rng);
  const Bytes queries = random_rows(100, &rng);
  const std::vector<Neighbours> first = search(reference, queries);
  (void)search(random_rows(777, &rng), random_rows(33, &rng));
  const std::vector<Neighbours> second = search(reference, queries);
  for (std::size_t q = 0; q < first.size(); ++q) {
    EXPECT_EQ(first[q].nearest, second[q].nearest);
    EXPECT_EQ(first[q].second, second[q].second);
    EXPECT_EQ(first[q].distance2_nearest, second[q].distance2_nearest);
  }
}

TEST(NearestDescriptors, HasNoSecond_WhenThereIsOneReference) {
  Rng rng(75, 0);
  const Bytes reference = random_rows(1, &rng);
  const std::vector<Neighbours> found = search(reference, reference);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].nearest, 0);
  EXPECT_EQ(found[0].distance2_nearest, 0.0F);
  EXPECT_EQ(found[0].second, -1);
}

TEST(NearestDescriptors, FindsNothing_AmongNoReferences_AndForNoQueries) {
  Rng rng(76, 0);
  const Bytes rows = random_rows(3, &rng);
  const std::vector<Neighbours> found = search({}, rows);
  for (const Neighbours& n : found) {
    EXPECT_EQ(n.nearest, -1);
    EXPECT_EQ(n.second, -1);
  }
  EXPECT_TRUE(search(rows, {}).empty());
}

}  // namespace
}  // namespace polhode::neighbours_test
