#include "shape/scale_number.hpp"

#include <gtest/gtest.h>

namespace polhode::scale_number_test {
namespace {

TEST(ScaleNumber, RisesByOneAtEachChange_AndNotBetween) {
  ScaleNumber scale;
  const LengthsUnit before;
  const LengthsUnit map_units{.target_frame = 1};
  const LengthsUnit metres{.known = true, .metres_per_mu = 0.3, .target_frame = 1};
  const LengthsUnit read_again{.known = true, .metres_per_mu = 0.4, .target_frame = 1};
  std::uint32_t number = 0;
  for (const LengthsUnit& unit : {before, map_units, metres, read_again, metres, map_units}) {
    change_unit(unit, &scale);
    EXPECT_EQ(scale.number, number);
    EXPECT_EQ(number_of(unit, scale), number) << "the same unit goes on under its number";
    ++number;
  }
}

TEST(ScaleNumber, MapUnitsOfAnotherMapAreAnotherUnit) {
  ScaleNumber scale{.number = 4, .unit = {.target_frame = 1}};
  EXPECT_EQ(number_of({.target_frame = 2}, scale), 5U);
  EXPECT_EQ(number_of({.target_frame = 1}, scale), 4U);
}

}  // namespace
}  // namespace polhode::scale_number_test
