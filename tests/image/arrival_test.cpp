#include "image/arrival.hpp"

#include <gtest/gtest.h>

namespace polhode::arrival_test {
namespace {

constexpr std::int64_t kPeriod_ns = 33'333'333;

TEST(MissingFrames, AreNone_WhenFramesComeEvenly) {
  ArrivalHistory history;
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(missing_frames(i * kPeriod_ns + i % 3 * 1'000'000, &history), 0);
  }
}

TEST(MissingFrames, AreAsManyAsFitTheGap) {
  for (int gap = 1; gap < 20; ++gap) {
    ArrivalHistory history;
    std::int64_t now_ns = 5'000'000'000;
    for (int i = 0; i < 6; ++i) {
      EXPECT_EQ(missing_frames(now_ns, &history), 0);
      now_ns += kPeriod_ns;
    }
    EXPECT_EQ(missing_frames(now_ns + gap * kPeriod_ns, &history), gap);
  }
}

TEST(MissingFrames, AreNone_WhenTheTimesFollowNoPeriod) {
  ArrivalHistory history;
  std::int64_t now_ns = 0;
  for (const int step : {10, 10, 10, 10, 14, 15, 16, 21, 14}) {
    now_ns += step * 100'000'000LL;
    EXPECT_EQ(missing_frames(now_ns, &history), 0) << step;
  }
}

TEST(MissingFrames, FollowAChangeOfPeriod) {
  ArrivalHistory history;
  std::int64_t now_ns = 0;
  int missing = 0;
  for (int i = 0; i < 40; ++i) {
    now_ns += i < 10 ? kPeriod_ns : 2 * kPeriod_ns;
    const int found = missing_frames(now_ns, &history);
    missing += i > 25 ? found : 0;
  }
  EXPECT_EQ(missing, 0);
}

TEST(MissingFrames, TimesDeliveredAgainCountNothing) {
  ArrivalHistory history;
  std::int64_t now_ns = 0;
  for (int i = 0; i < 10; ++i) {
    now_ns += kPeriod_ns;
    EXPECT_EQ(missing_frames(now_ns, &history), 0);
    EXPECT_EQ(missing_frames(now_ns, &history), 0);
    EXPECT_EQ(missing_frames(now_ns - kPeriod_ns / 2, &history), 0);
  }
  EXPECT_EQ(missing_frames(now_ns + 3 * kPeriod_ns, &history), 2);
}

}  // namespace
}  // namespace polhode::arrival_test
