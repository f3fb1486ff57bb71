#include "os/linux/assertion.hpp"

#include <gtest/gtest.h>

#include "base/assert.hpp"

namespace polhode::platform::assertion_test {
namespace {

void fail() {
  print_assertions();
  const int frames = 7;
  POLHODE_ASSERT(frames < 3, frames);
}

TEST(AssertionDeathTest, TellsPlaceExpressionAndValue) {
  EXPECT_DEATH(fail(),
               "polhode: .*assertion_test.cpp:13: assertion failed: frames < 3 .7.; the run ends");
}

}  // namespace
}  // namespace polhode::platform::assertion_test
