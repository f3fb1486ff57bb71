#include "base/median.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace polhode::median_test {
namespace {

TEST(Median, IsTheMiddleOfAnOddNumber_AndTheUpperOfTwo) {
  std::vector<double> odd{5.0, 1.0, 9.0};
  std::vector<int> even{4, 1, 3, 2};
  EXPECT_EQ(median(std::span(odd)), 5.0);
  EXPECT_EQ(median(std::span(even)), 3);
}

TEST(Median, OfNothing_IsZero) { EXPECT_EQ(median(std::span<double>()), 0.0); }

TEST(Ranked, AgreesWithSorting_AndKeepsTheValues) {
  const std::vector<int> sorted{-3, 0, 0, 2, 7, 11, 11, 40};
  for (std::size_t rank = 0; rank < sorted.size(); ++rank) {
    std::vector<int> mixed{11, 0, 40, -3, 7, 0, 2, 11};
    EXPECT_EQ(ranked(std::span(mixed), rank), sorted[rank]);
    std::sort(mixed.begin(), mixed.end());
    EXPECT_EQ(mixed, sorted);
  }
}

}  // namespace
}  // namespace polhode::median_test
