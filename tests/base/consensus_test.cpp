#include "base/consensus.hpp"

#include <gtest/gtest.h>

namespace polhode {
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
  EXPECT_EQ(draws_needed(0.0, 3, 1e-2), draws_needed(0.01, 3, 1e-2));
}

}  // namespace
}  // namespace polhode
