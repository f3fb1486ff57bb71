#include "base/assert.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdio>

namespace polhode::assert_test {
namespace {

void report_to_stderr(const AssertionReport& report) {
  std::fprintf(stderr, "%s|%s|%d|%g\n", report.expression, report.file, report.line, report.value);
}

TEST(AssertDeathTest, HandsExpressionPlaceAndValueToTheHook_ThenAborts) {
  // The hook returns: that does not save the process.
  EXPECT_EXIT(
      {
        set_assertion_hook(report_to_stderr);
        assertion_failed("a < b", "some_file.cpp", 12, 3.5);
      },
      testing::KilledBySignal(SIGABRT),
      "a < b.some_file.cpp.12.3.5");
}

TEST(AssertDeathTest, AbortsWithoutAHook) {
  EXPECT_EXIT(
      {
        set_assertion_hook(nullptr);
        assertion_failed("a < b", "some_file.cpp", 12, 3.5);
      },
      testing::KilledBySignal(SIGABRT),
      "");
}

TEST(AssertDeathTest, OfTheMacroNamesItsOwnLineAndTakesAnyNumberForTheValue) {
  const unsigned count = 7;
  EXPECT_EXIT(
      {
        set_assertion_hook(report_to_stderr);
        POLHODE_ASSERT(count < 7, count);
      },
      testing::KilledBySignal(SIGABRT),
      "count < 7.*assert_test.cpp.*7");
}

TEST(Assert, ThatHoldsCallsNothingAndDoesNotEvaluateTheValue) {
  int evaluated = 0;
  int calls = 0;
  const auto holds = [&calls] {
    ++calls;
    return true;
  };
  POLHODE_ASSERT(holds(), ++evaluated);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(evaluated, 0);
}

}  // namespace
}  // namespace polhode::assert_test
