#include "image/quality.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "base/rng.hpp"
#include "pictures.hpp"

namespace polhode::quality_test {
namespace {

using namespace images;

TEST(MeasureLevels, CallsABlackImageDark_AndABrightOneNot) {
  EXPECT_TRUE(measure_levels(constant(64, 48, 0), {}).dark);
  EXPECT_FALSE(measure_levels(constant(64, 48, 128), {}).dark);
  EXPECT_DOUBLE_EQ(measure_levels(constant(64, 48, 51), {}).bright_level, 0.2);
}

TEST(MeasureLevels, ComparesWithTheDarkLevelThatItIsGiven) {
  const cv::Mat gray = constant(64, 48, 51);  // a fifth of full scale
  EXPECT_TRUE(measure_levels(gray, {.dark_level = 0.21}).dark);
  EXPECT_FALSE(measure_levels(gray, {.dark_level = 0.19}).dark);
}

TEST(MeasureLevels, StaysDark_WhenOnlyAFewHotPixelsShine) {
  cv::Mat gray = constant(100, 100, 0);
  for (int i = 0; i < 9; ++i) {  // 9 of 10 000: under the one in a thousand that counts
    gray.at<std::uint8_t>(11 * i, 7 * i) = 255;
  }
  EXPECT_TRUE(measure_levels(gray, {}).dark);
  cv::Mat target = constant(100, 100, 0);
  target(cv::Rect(40, 40, 5, 5)).setTo(200);  // 25 of 10 000
  EXPECT_FALSE(measure_levels(target, {}).dark);
  EXPECT_DOUBLE_EQ(measure_levels(target, {}).bright_level, 200.0 / 255.0);
}

TEST(MeasureLevels, SeesASmallTarget_HoweverLargeTheImageIs) {
  for (const cv::Size size : {cv::Size(1920, 1080), cv::Size(8192, 5460)}) {
    cv::Mat gray(size, CV_8UC1, cv::Scalar(0));
    gray(cv::Rect(700, 500, 35, 50)).setTo(200);  // a body of 70 px, half of it lit
    EXPECT_FALSE(measure_levels(gray, {}).dark) << size;
    EXPECT_DOUBLE_EQ(measure_levels(gray, {}).bright_level, 200.0 / 255.0);
  }
}

TEST(MeasureLevels, CountsSaturatedPixels_WhenTheyAreFew) {
  cv::Mat gray = constant(100, 100, 100);
  for (int i = 0; i < 7; ++i) {
    gray.at<std::uint8_t>(i, i) = 255;
  }
  EXPECT_DOUBLE_EQ(measure_levels(gray, {}).saturated_fraction, 7e-4);
  EXPECT_DOUBLE_EQ(measure_levels(constant(100, 100, 100), {}).saturated_fraction, 0.0);
}

TEST(MeasureLevels, CountsTheLastColumn_WhateverTheWidth) {
  for (int width = 97; width <= 100; ++width) {
    cv::Mat gray = constant(width, 100, 100);
    gray.at<std::uint8_t>(50, width - 1) = 255;
    EXPECT_DOUBLE_EQ(measure_levels(gray, {}).saturated_fraction, 0.01 / width);
  }
}

TEST(MeasureLevels, CountsAllSaturatedPixels_WhenTheyHaveDifferentLevels) {
  cv::Mat gray = constant(100, 100, 100);
  gray.rowRange(0, 40).setTo(252);  // over 0.98 of full scale
  gray.rowRange(40, 50).setTo(255);
  EXPECT_DOUBLE_EQ(measure_levels(gray, {}).saturated_fraction, 0.5);
}

TEST(MeasureLevels, LooksOnlyAtTheImage_WhenItIsAPartOfALargerOne) {
  cv::Mat whole = constant(64, 64, 255);
  cv::Mat part = whole(cv::Rect(10, 10, 20, 20));
  part.setTo(0);
  const ImageLevels quality = measure_levels(part, {});
  EXPECT_TRUE(quality.dark);
  EXPECT_DOUBLE_EQ(quality.saturated_fraction, 0.0);
}

TEST(MeasureLevels, MeasuresWhatIsLit) {
  cv::Mat gray = constant(100, 100, 0);
  gray(cv::Rect(10, 10, 50, 20)).setTo(80);
  EXPECT_DOUBLE_EQ(measure_levels(gray, {}).lit_fraction, 0.1);
  EXPECT_DOUBLE_EQ(measure_levels(gray, {}).mean_level, 0.1 * 80.0 / 255.0);
}

/// Of an image with nothing before it.
BitErrorTraces traces_of(const cv::Mat& gray) {
  QualityHistory history;
  return find_bit_errors(gray, &history);
}

// verifies: IMG-04
TEST(FindBitErrors, CountsEachFlippedPixel_WhateverItsColumn) {
  for (int u = 1; u + 1 < 70; ++u) {
    cv::Mat gray = constant(70, 40, 100);
    gray.at<std::uint8_t>(17, u) = 100 ^ 0x80;
    EXPECT_DOUBLE_EQ(traces_of(gray).impulse_fraction, 1.0 / 2800.0) << u;
  }
}

TEST(FindBitErrors, CountsEachFlippedPixel_OfAWideRow) {
  constexpr int kFlips = 260;  // sixteen columns apart: more than a byte counts
  cv::Mat gray = constant(16 * kFlips + 2, 40, 100);
  for (int i = 0; i < kFlips; ++i) {
    gray.at<std::uint8_t>(17, 1 + 16 * i) = 100 ^ 0x80;
  }
  EXPECT_DOUBLE_EQ(traces_of(gray).impulse_fraction, kFlips / static_cast<double>(gray.total()));
}

TEST(FindBitErrors, CountsNeitherEdgesNorLinesNorGrain) {
  cv::Mat gray = constant(100, 100, 3);
  gray(cv::Rect(20, 20, 40, 40)).setTo(180);
  cv::line(gray, cv::Point(70, 10), cv::Point(90, 90), cv::Scalar(200));  // a strut, a pixel wide
  Rng rng(5, 0);
  for (int i = 0; i < 10000; ++i) {
    gray.data[i] = static_cast<std::uint8_t>(gray.data[i] + rng.below(12));
  }
  const BitErrorTraces traces = traces_of(gray);
  EXPECT_EQ(traces.impulse_fraction, 0.0);
  EXPECT_EQ(traces.rough_tiles, 0);
  EXPECT_EQ(traces.lines, 0);
}

TEST(FindBitErrors, CountsRandomTilesAndBrokenLines) {
  cv::Mat gray = constant(160, 160, 100);
  Rng rng(6, 0);
  for (int v = 32; v < 64; ++v) {
    for (int u = 16; u < 48; ++u) {
      gray.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(rng.below(256));
    }
  }
  EXPECT_EQ(traces_of(gray).rough_tiles, 4);
  for (int u = 0; u < 160; ++u) {
    gray.at<std::uint8_t>(100, u) = static_cast<std::uint8_t>(rng.below(256));
  }
  EXPECT_EQ(traces_of(gray).lines, 1);
}

TEST(FindBitErrors, CountsALineOnce_ThatStaysWhereItIs) {
  cv::Mat crossed = constant(160, 160, 100);
  crossed.row(80).setTo(255);
  QualityHistory history;
  EXPECT_EQ(find_bit_errors(crossed, &history).lines, 1);
  EXPECT_EQ(find_bit_errors(crossed, &history).lines, 0) << "a crosshair";
  cv::Mat broken = crossed.clone();
  broken.row(40).setTo(255);
  EXPECT_EQ(find_bit_errors(broken, &history).lines, 1) << "beside it an error";
  const cv::Mat clean = constant(160, 160, 100);
  for (std::size_t frame = 0; frame < QualityHistory::kFrames; ++frame) {
    EXPECT_EQ(find_bit_errors(clean, &history).lines, 0);
  }
  EXPECT_EQ(find_bit_errors(crossed, &history).lines, 1) << "forgotten";
}

TEST(FindBitErrors, CountsNoTile_WhereTheLastGoodImageWasNearlyAsRough) {
  Rng rng(7, 0);
  const auto grained = [&](std::uint32_t levels) {
    cv::Mat gray = constant(160, 160, 60);
    for (int v = 32; v < 64; ++v) {
      for (int u = 16; u < 48; ++u) {
        gray.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(60 + rng.below(levels));
      }
    }
    return gray;
  };
  QualityHistory history;
  // Neighbours differ by a third of the range: 37 levels, then 50, then 65.
  for (const std::uint32_t levels : {110U, 150U, 195U}) {
    EXPECT_EQ(assess(grained(levels), {}, &history).decision, FrameDecision::kUse);
  }
  history = {};
  (void)assess(constant(160, 160, 60), {}, &history);
  EXPECT_EQ(find_bit_errors(grained(150), &history).rough_tiles, 4);
}

TEST(FindBitErrors, TakesImagesOfAnySize) {
  for (int side = 1; side < 40; ++side) {
    const BitErrorTraces traces = traces_of(constant(side, 40 - side, 100));
    EXPECT_EQ(traces.impulse_fraction, 0.0);
    EXPECT_EQ(traces.rough_tiles + traces.lines, 0);
  }
}

RepeatedRows compare_with(const cv::Mat& now,
                          const cv::Mat& before,
                          const cv::Mat& good = cv::Mat()) {
  QualityHistory history;
  history.previous = before;
  if (!good.empty()) {
    remember_rows(good, &history);
  }
  return compare_rows(now, {}, history);
}

TEST(CompareRows, CountsNothing_WithoutAFrameBefore_OrWhereRowsAreBlank) {
  EXPECT_EQ(compare_with(image(0, 1), cv::Mat()).fresh, 0);
  const RepeatedRows blank = compare_with(constant(80, 60, 0), constant(80, 60, 0));
  EXPECT_EQ(blank.repeated + blank.fresh, 0);
}

TEST(CompareRows, CountsRowsOfTheFrameBefore) {
  const cv::Mat before = image(0, 1);
  cv::Mat now = image(1, 2);
  EXPECT_EQ(compare_with(now, before).repeated, 0);
  before.rowRange(0, 50).copyTo(now.rowRange(0, 50));
  const RepeatedRows rows = compare_with(now, before);
  EXPECT_EQ(rows.repeated, 50);
  EXPECT_EQ(rows.fresh, kHeight - 50);
  EXPECT_EQ(rows.changes, 1);
}

TEST(CompareRows, CountsTheRestOfAWhiteOrBlackFrame_WhereThereWasSomethingElse) {
  for (const int level : {0, 255}) {
    cv::Mat good = image(0, 1);
    good += cv::Scalar(60);  // something in every row
    const cv::Mat before = constant(kWidth, kHeight, level);
    cv::Mat now = good.clone();
    now.rowRange(0, 50).setTo(level);
    EXPECT_EQ(compare_with(now, before).repeated, 0) << "nobody knows what was there";
    EXPECT_EQ(compare_with(now, before, now).repeated, 0)
        << "it was there in the last good picture";
    const RepeatedRows rows = compare_with(now, before, good);
    EXPECT_EQ(rows.repeated, 50);
    EXPECT_EQ(rows.fresh, kHeight - 50);
    EXPECT_EQ(rows.changes, 1);
    now = good.clone();
    now.rowRange(0, kHeight / 10).setTo(level);
    EXPECT_EQ(compare_with(now, before, good).repeated, 0) << "an edge moves as far";
    EXPECT_EQ(compare_with(before, before, good).repeated, 0)
        << "white or dark twice is no repeated buffer";
  }
}

}  // namespace
}  // namespace polhode::quality_test
