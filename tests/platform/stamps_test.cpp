#include "camera/replay/stamps.hpp"

#include <gtest/gtest.h>

#include "errors.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::stamps_test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kFirst_ns = 1'700'000'000 * kSecond_ns;

/// Ninety images at a rate, stamped in units of so many nanoseconds.
std::vector<std::int64_t> stamps(double rate_hz, std::int64_t unit_ns) {
  std::vector<std::int64_t> out;
  for (int i = 0; i < 90; ++i) {
    out.push_back((kFirst_ns + static_cast<std::int64_t>(1e9 * i / rate_hz)) / unit_ns);
  }
  return out;
}

std::string refusal(std::span<const std::int64_t> stamps_ns, std::optional<double> rate_hz) {
  return refusal_of<UnusableInput>(
      [&] { (void)stamp_warnings(stamps_ns, rate_hz, "SEQ/mav0/cam0/data.csv"); });
}

bool holds(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Stamps, GoodOnesRaiseNoDoubt) {
  EXPECT_TRUE(stamp_warnings(stamps(1.0, 1), 1.0, "t").empty());
  EXPECT_TRUE(stamp_warnings(stamps(29.97, 1), 30.0, "t").empty());
  EXPECT_TRUE(stamp_warnings(stamps(1.0 / 3600, 1), std::nullopt, "t").empty());
  EXPECT_TRUE(stamp_warnings(stamps(5000.0, 1), 5000.0, "t").empty());
  const std::vector<std::int64_t> single = {0};
  EXPECT_TRUE(stamp_warnings(single, 1.0, "t").empty());
}

TEST(Stamps, OtherUnitsAreRefused_NamingFileIntervalAndRate) {
  const std::string micro = refusal(stamps(1.0, 1000), 1.0);
  EXPECT_TRUE(holds(micro, "SEQ/mav0/cam0/data.csv: timestamp [ns]")) << micro;
  EXPECT_TRUE(holds(micro, "0.001 s apart")) << micro;
  EXPECT_TRUE(holds(micro, "rate_hz: 1,") || holds(micro, "rate_hz: 1;")) << micro;
  EXPECT_TRUE(holds(micro, "look like microseconds")) << micro;
  EXPECT_TRUE(holds(refusal(stamps(10.0, 1'000'000), 10.0), "look like milliseconds"));
  EXPECT_TRUE(holds(refusal(stamps(1.0, kSecond_ns), 1.0), "look like seconds or frame numbers"));
}

TEST(Stamps, MoreImagesThanAnyCameraTakesAreRefusedWithoutARate) {
  const std::vector<std::int64_t> numbers = {0, 1, 2, 3, 4};
  const std::string line = refusal(numbers, std::nullopt);
  EXPECT_TRUE(holds(line, "1e+09 a second")) << line;
  EXPECT_TRUE(holds(line, "names no rate_hz")) << line;
}

TEST(Stamps, AnotherRateThanTheCamerasIsReported) {
  const auto slower = stamp_warnings(stamps(1.0 / 3600, 1), 1.0, "data.csv");
  ASSERT_EQ(slower.size(), 1U);
  EXPECT_TRUE(holds(slower[0], "data.csv: timestamp [ns]: the pictures are 3600 s apart"));
  EXPECT_TRUE(holds(slower[0], "rate_hz: 1"));
  EXPECT_EQ(stamp_warnings(stamps(30.0, 1), 10.0, "t").size(), 1U);
}

TEST(Stamps, StampsOfArrivalAreReported_LostFramesAtUnevenTimesAreNot) {
  std::vector<std::int64_t> arrival;
  std::vector<std::int64_t> lost;
  for (std::int64_t i = 0; i < 80; ++i) {
    arrival.push_back(kFirst_ns + 400'000'000 * (i / 4) + 5'000'000 * (i % 4));
    if (i % 7 < 4) {
      lost.push_back(kFirst_ns + 100'000'000 * i);
    }
  }
  const auto warnings = stamp_warnings(arrival, std::nullopt, "data.csv");
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(holds(warnings[0], "19 of 79 intervals")) << warnings[0];
  EXPECT_TRUE(stamp_warnings(lost, 10.0, "t").empty());
}

TEST(Stamps, FramesThatAreMissingAmongRegularOnesAreCounted) {
  std::vector<std::int64_t> eclipse;
  std::vector<std::int64_t> tenth;
  std::vector<std::int64_t> few;
  for (std::int64_t i = 0; i < 80; ++i) {
    eclipse.push_back(kFirst_ns + 100'000'000 * i + (i > 40 ? 2000 : 0) * kSecond_ns);
    if (i % 10 != 5) {
      tenth.push_back(kFirst_ns + 100'000'000 * i);
    }
    if (i % 20 != 5) {
      few.push_back(kFirst_ns + 100'000'000 * i);
    }
  }
  const auto pause = stamp_warnings(eclipse, 10.0, "data.csv");
  ASSERT_EQ(pause.size(), 1U);
  EXPECT_TRUE(holds(pause[0], "about 20000 frames are missing between the 80")) << pause[0];
  EXPECT_TRUE(holds(pause[0], "in the 2000.1 s after 1700000004000000000")) << pause[0];
  // In the mean: sensor.yaml may count the pause in, and is not contradicted.
  EXPECT_EQ(stamp_warnings(eclipse, 79.0 / 2007.9, "t").size(), 1U);
  ASSERT_EQ(stamp_warnings(tenth, 10.0, "t").size(), 1U);
  EXPECT_TRUE(holds(stamp_warnings(tenth, 10.0, "t")[0], "about 8 frames are missing"));
  EXPECT_TRUE(stamp_warnings(few, 10.0, "t").empty());
}

}  // namespace
}  // namespace polhode::platform::stamps_test
