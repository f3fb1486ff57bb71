#include "camera/v4l2/frame_time.hpp"

#include <gtest/gtest.h>

namespace polhode::platform::frame_time_test {
namespace {

// verifies: LIV-11
TEST(MidExposure, IsHalfAnExposureAfterItsStart) {
  EXPECT_EQ(
      mid_exposure_ns(
          1'000'000,
          {.stamped_at = StampedAt::kStartOfExposure, .exposure_ns = 20'000, .readout_ns = 7}),
      1'010'000);
}

// verifies: LIV-11
TEST(MidExposure, IsReadoutAndHalfAnExposureBeforeTheEndOfTheFrame) {
  EXPECT_EQ(mid_exposure_ns(
                1'000'000,
                {.stamped_at = StampedAt::kEndOfFrame, .exposure_ns = 20'000, .readout_ns = 5'000}),
            985'000);
}

TEST(MidExposure, WithNothingKnownIsTheStamp) { EXPECT_EQ(mid_exposure_ns(123, {}), 123); }

TEST(SequenceWatch, CountsWhatIsMissingBetweenNumbers) {
  SequenceWatch watch;
  EXPECT_EQ(watch.missing_before(17), 0U);  // where it begins indicates nothing
  EXPECT_EQ(watch.missing_before(18), 0U);
  EXPECT_EQ(watch.missing_before(22), 3U);
}

TEST(SequenceWatch, GoesOverTheEndOfTheCounter) {
  SequenceWatch watch;
  (void)watch.missing_before(0xFFFFFFFE);
  EXPECT_EQ(watch.missing_before(1), 2U);  // 0xFFFFFFFF and 0
}

TEST(SequenceWatch, ACounterThatStandsOrBeginsAgainIsNoGap) {
  SequenceWatch watch;
  (void)watch.missing_before(500);
  EXPECT_EQ(watch.missing_before(500), 0U);
  EXPECT_EQ(watch.missing_before(0), 0U);
  watch.restart();
  EXPECT_EQ(watch.missing_before(40), 0U);
}

TEST(Backoff, DoublesUpToItsBound_AndBeginsAgainAfterSuccess) {
  Backoff backoff;
  EXPECT_EQ(backoff.due_ns(), 0);
  std::int64_t last = 0;
  for (int i = 0; i < 20; ++i) {
    backoff.failed(0);
    EXPECT_GE(backoff.due_ns(), last);
    EXPECT_LE(backoff.due_ns(), Backoff::kLongest_ns);
    last = backoff.due_ns();
  }
  EXPECT_EQ(last, Backoff::kLongest_ns);
  backoff.succeeded();
  backoff.failed(0);
  EXPECT_EQ(backoff.due_ns(), Backoff::kFirst_ns);
}

}  // namespace
}  // namespace polhode::platform::frame_time_test
