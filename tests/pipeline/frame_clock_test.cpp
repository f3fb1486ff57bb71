// Which frames are admitted by their time.
#include "pipeline/frame_clock.hpp"

#include <gtest/gtest.h>

namespace polhode::frame_clock_test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// A clock that has admitted and looked at frames of these seconds.
FrameClock after_seconds(int first, int last) {
  FrameClock clock;
  std::uint32_t missing = 0;
  for (int second = first; second <= last; ++second) {
    EXPECT_EQ(admit(second * kSecond_ns, &clock, &missing), Admission::kLater);
    clock.timestamp_ns = second * kSecond_ns;
    clock.time_known = true;
  }
  return clock;
}

TEST(FrameClock, TheFirstFrameMayHaveAnyTime) {
  FrameClock clock;
  std::uint32_t missing = 7;
  EXPECT_EQ(admit(-5, &clock, &missing), Admission::kLater);
  EXPECT_EQ(missing, 0U);
}

TEST(FrameClock, ATimeThatNoDifferenceCanBeTakenFromIsPassedBy) {
  for (const std::int64_t time_ns : {INT64_MIN, INT64_MIN / 2, INT64_MAX / 2, INT64_MAX}) {
    FrameClock clock;
    std::uint32_t missing = 0;
    EXPECT_EQ(admit(time_ns, &clock, &missing), Admission::kNotLater) << time_ns;
    clock = after_seconds(1, 5);
    for (int i = 0; i < 20; ++i) {
      EXPECT_EQ(admit(time_ns, &clock, &missing), Admission::kNotLater) << "ten do not outvote";
    }
    EXPECT_EQ(admit(6 * kSecond_ns, &clock, &missing), Admission::kLater);
  }
}

TEST(FrameClock, AFrameThatIsNotLaterIsPassedBy) {
  FrameClock clock = after_seconds(1, 5);
  std::uint32_t missing = 0;
  EXPECT_EQ(admit(5 * kSecond_ns, &clock, &missing), Admission::kNotLater);
  EXPECT_EQ(admit(2 * kSecond_ns, &clock, &missing), Admission::kNotLater);
  EXPECT_EQ(clock.timestamp_ns, 5 * kSecond_ns);
}

TEST(FrameClock, FramesThatNeverCameAreCounted) {
  FrameClock clock = after_seconds(1, 10);
  std::uint32_t missing = 0;
  EXPECT_EQ(admit(14 * kSecond_ns, &clock, &missing), Admission::kLater);
  EXPECT_EQ(missing, 3U);
}

/// One bit of a time stamp is 36 years: no gap in the pictures, and no damaged memory.
TEST(FrameClock, AFrameThatIsLaterThanARunLastsIsPassedBy_UnlessTenAgree) {
  FrameClock clock = after_seconds(1, 5);
  std::uint32_t missing = 0;
  constexpr std::int64_t kYears36_ns = std::int64_t{1} << 60U;
  EXPECT_EQ(admit(6 * kSecond_ns + kYears36_ns, &clock, &missing), Admission::kNotLater);
  EXPECT_EQ(missing, 0U);
  EXPECT_EQ(clock.timestamp_ns, 5 * kSecond_ns);
  EXPECT_EQ(admit(7 * kSecond_ns, &clock, &missing), Admission::kLater);
  for (int second = 8; second < 17; ++second) {
    ASSERT_EQ(admit(second * kSecond_ns + kYears36_ns, &clock, &missing), Admission::kNotLater);
  }
  EXPECT_EQ(admit(17 * kSecond_ns + kYears36_ns, &clock, &missing), Admission::kTimeWasWrong);
  EXPECT_EQ(clock.timestamp_ns, 17 * kSecond_ns + kYears36_ns);
}

// verifies: IMG-07
TEST(FrameClock, TenLaterAndLaterFramesOutvoteAWrongTime) {
  FrameClock clock = after_seconds(1, 3);
  std::uint32_t missing = 0;
  ASSERT_EQ(admit(1000 * kSecond_ns, &clock, &missing), Admission::kLater);
  clock.timestamp_ns = 1000 * kSecond_ns;  // the wrong one
  int second = 4;
  while (second < 40 && admit(second * kSecond_ns, &clock, &missing) == Admission::kNotLater) {
    ++second;
  }
  EXPECT_EQ(second, 4 + 9) << "the tenth of them";
  EXPECT_EQ(clock.timestamp_ns, second * kSecond_ns) << "time goes on from it";
}

}  // namespace
}  // namespace polhode::frame_clock_test
