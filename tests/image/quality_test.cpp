#include "image/quality.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "base/rng.hpp"

namespace polhode {
namespace {

cv::Mat constant(int width, int height, int level) {
  cv::Mat gray(height, width, CV_8UC1);
  gray.setTo(level);
  return gray;
}

constexpr int kWidth = 160;
constexpr int kHeight = 120;

/// A sensor's picture of a body before black space: a smooth texture, shifted by `shift_px`, with
/// noise of its own.
cv::Mat picture(int shift_px, std::uint64_t seed) {
  cv::Mat gray(kHeight, kWidth, CV_8UC1);
  Rng rng(seed, 0);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const int x = u - shift_px;
      const bool body = x > 40 && x < 120 && v > 20 && v < 100;
      const int texture = 90 + ((x / 5 + v / 7) % 3) * 30;
      gray.at<std::uint8_t>(v, u) =
          static_cast<std::uint8_t>((body ? texture : 2) + static_cast<int>(rng.below(5)));
    }
  }
  return gray;
}

/// A history of good frames; the next is number `frames`.
struct Watch {
  QualityHistory history;
  ImageOptions options;
  int next = 0;
  explicit Watch(int frames = 6) {
    for (int i = 0; i < frames; ++i) {
      const FrameVerdict verdict = show(good());
      EXPECT_EQ(verdict.fault, FrameFault::kNone) << "frame " << i;
      EXPECT_EQ(verdict.decision, FrameDecision::kUse);
    }
  }
  cv::Mat good() const { return picture(next, static_cast<std::uint64_t>(next)); }
  FrameVerdict show(const cv::Mat& gray) {
    ++next;
    return assess(gray, options, &history);
  }
};

void expect_skipped(const FrameVerdict& verdict, FrameFault fault) {
  EXPECT_EQ(verdict.fault, fault);
  EXPECT_EQ(verdict.decision, FrameDecision::kSkip);
  EXPECT_NE(verdict.faults & 1U << static_cast<unsigned>(fault), 0U);
}

void expect_good(const FrameVerdict& verdict) {
  EXPECT_EQ(verdict.fault, FrameFault::kNone);
  EXPECT_EQ(verdict.decision, FrameDecision::kUse);
  EXPECT_EQ(verdict.faults, 0);
}

TEST(MeasureLevels, CallsABlackPictureDark_AndABrightOneNot) {
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

TEST(MeasureLevels, SeesASmallTarget_HoweverLargeThePictureIs) {
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

TEST(MeasureLevels, CountsAllSaturatedPixels_WhenTheyHaveDifferentLevels) {
  cv::Mat gray = constant(100, 100, 100);
  gray.rowRange(0, 40).setTo(252);  // over 0.98 of full scale
  gray.rowRange(40, 50).setTo(255);
  EXPECT_DOUBLE_EQ(measure_levels(gray, {}).saturated_fraction, 0.5);
}

TEST(MeasureLevels, LooksOnlyAtThePicture_WhenItIsAPartOfALargerOne) {
  cv::Mat whole = constant(64, 64, 255);
  cv::Mat part = whole(cv::Rect(10, 10, 20, 20));
  part.setTo(0);
  const ImageLevels quality = measure_levels(part, {});
  EXPECT_TRUE(quality.dark);
  EXPECT_DOUBLE_EQ(quality.saturated_fraction, 0.0);
}

TEST(MeasureLevels, TellsWhatIsLit) {
  cv::Mat gray = constant(100, 100, 0);
  gray(cv::Rect(10, 10, 50, 20)).setTo(80);
  EXPECT_DOUBLE_EQ(measure_levels(gray, {}).lit_fraction, 0.1);
  EXPECT_DOUBLE_EQ(measure_levels(gray, {}).mean_level, 0.1 * 80.0 / 255.0);
}

/// Of a picture with nothing before it.
BitErrorTraces traces_of(const cv::Mat& gray) {
  QualityHistory history;
  return find_bit_errors(gray, &history);
}

TEST(FindBitErrors, CountsEachFlippedPixel_WhateverItsColumn) {
  for (int u = 1; u + 1 < 70; ++u) {
    cv::Mat gray = constant(70, 40, 100);
    gray.at<std::uint8_t>(17, u) = 100 ^ 0x80;
    EXPECT_DOUBLE_EQ(traces_of(gray).impulse_fraction, 1.0 / 2800.0) << u;
  }
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

TEST(FindBitErrors, CountsNoTile_WhereTheLastGoodPictureWasNearlyAsRough) {
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

TEST(FindBitErrors, TakesPicturesOfAnySize) {
  for (int side = 1; side < 40; ++side) {
    const BitErrorTraces traces = traces_of(constant(side, 40 - side, 100));
    EXPECT_EQ(traces.impulse_fraction, 0.0);
    EXPECT_EQ(traces.rough_tiles + traces.lines, 0);
  }
}

TEST(CompareRows, SaysNothing_WithoutAFrameBefore_OrWhereRowsAreBlank) {
  EXPECT_EQ(compare_rows(picture(0, 1), cv::Mat()).fresh, 0);
  const RepeatedRows blank = compare_rows(constant(80, 60, 0), constant(80, 60, 0));
  EXPECT_EQ(blank.repeated + blank.fresh, 0);
}

TEST(CompareRows, CountsRowsOfTheFrameBefore) {
  const cv::Mat before = picture(0, 1);
  cv::Mat now = picture(1, 2);
  EXPECT_EQ(compare_rows(now, before).repeated, 0);
  before.rowRange(0, 50).copyTo(now.rowRange(0, 50));
  const RepeatedRows rows = compare_rows(now, before);
  EXPECT_EQ(rows.repeated, 50);
  EXPECT_EQ(rows.fresh, kHeight - 50);
  EXPECT_EQ(rows.changes, 1);
}

TEST(Assess, SkipsAFrozenFrame_AndGoesOn) {
  Watch watch;
  expect_skipped(watch.show(watch.history.previous.clone()), FrameFault::kFrozen);
  expect_good(watch.show(watch.good()));
}

TEST(Assess, SkipsAFrozenCamera_HoweverLong) {
  Watch watch;
  const cv::Mat last = watch.history.previous.clone();
  for (int i = 0; i < 40; ++i) {
    expect_skipped(watch.show(last), FrameFault::kFrozen);
  }
}

TEST(Assess, SkipsATornFrame_FromEitherEnd) {
  for (const bool upper : {true, false}) {
    Watch watch;
    cv::Mat torn = watch.good();
    const cv::Range rows = upper ? cv::Range(0, 60) : cv::Range(60, kHeight);
    watch.history.previous.rowRange(rows).copyTo(torn.rowRange(rows));
    expect_skipped(watch.show(torn), FrameFault::kTorn);
    expect_good(watch.show(watch.good()));
  }
}

TEST(Assess, GetsUsedToRowsThatStay_InASceneWithoutNoise) {
  QualityHistory history;
  int skipped = 0;
  FrameVerdict last;
  for (int i = 0; i < 30; ++i) {
    cv::Mat gray = picture(0, 1);  // the same noise in each frame: what does not move is equal
    gray(cv::Rect(60 + i, 70, 20, 20)).setTo(200);
    last = assess(gray, {}, &history);
    skipped += last.decision == FrameDecision::kSkip ? 1 : 0;
  }
  EXPECT_GE(skipped, 1);
  EXPECT_LE(skipped, 3);
  EXPECT_EQ(last.decision, FrameDecision::kUse) << "such a frame is whole";
  EXPECT_EQ(last.fault, FrameFault::kNone);
}

TEST(Assess, ADarkFrameDeliveredTwiceIsDark_ThenFrozen) {
  Watch watch;
  cv::Mat dark;
  watch.good().convertTo(dark, CV_8U, 0.1);
  expect_skipped(watch.show(dark), FrameFault::kDark);
  expect_skipped(watch.show(dark.clone()), FrameFault::kFrozen);
}

TEST(Assess, NamesTheFaultThatAFrameIsSkippedFor) {
  QualityHistory history;
  for (int i = 0; i < 12; ++i) {
    cv::Mat gray = picture(0, 1);
    gray(cv::Rect(60 + i, 70, 20, 20)).setTo(200);
    (void)assess(gray, {}, &history);
  }
  cv::Mat broken = picture(0, 1);  // its rows repeat as always, and a block of it is octets by chance
  broken(cv::Rect(72, 70, 20, 20)).setTo(200);
  Rng rng(3, 0);
  for (int v = 16; v < 64; ++v) {
    for (int u = 16; u < 112; ++u) {
      broken.at<std::uint8_t>(v, u) = static_cast<std::uint8_t>(rng.below(256));
    }
  }
  expect_skipped(assess(broken, {}, &history), FrameFault::kBitErrors);
}

TEST(Assess, SkipsAFrameThatLostItsLight_AndUsesTheNext) {
  for (const double factor : {0.0, 0.03, 0.1, 0.2}) {
    Watch watch;
    cv::Mat dim;
    watch.good().convertTo(dim, CV_8U, factor);
    expect_skipped(watch.show(dim), FrameFault::kDark);
    expect_good(watch.show(watch.good()));
  }
}

TEST(Assess, UsesAFrameThatLostAThirdOfItsLight) {
  Watch watch;
  cv::Mat dim;
  watch.good().convertTo(dim, CV_8U, 0.67);
  EXPECT_NE(watch.show(dim).decision, FrameDecision::kSkip);
}

TEST(Assess, GetsUsedToLessLight) {
  Watch watch;
  int skipped = 0;
  for (int i = 0; i < 20; ++i) {
    cv::Mat dim;
    watch.good().convertTo(dim, CV_8U, 0.2);
    skipped += watch.show(dim).decision == FrameDecision::kSkip ? 1 : 0;
  }
  EXPECT_LE(skipped, 3);
}

TEST(Assess, NeverUsesADarkPicture_HoweverLong) {
  Watch watch;
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(watch.show(constant(kWidth, kHeight, 1)).decision, FrameDecision::kSkip);
  }
}

TEST(Assess, SkipsAnOverexposedFrame_ButNotAnOverexposedSequence) {
  for (const double factor : {3.0, 5.0, 20.0}) {
    Watch watch;
    cv::Mat bright;
    watch.good().convertTo(bright, CV_8U, factor);
    expect_skipped(watch.show(bright), FrameFault::kSaturated);
    int skipped = 1;
    for (int i = 0; i < 20; ++i) {
      watch.good().convertTo(bright, CV_8U, factor);
      skipped += watch.show(bright).decision == FrameDecision::kSkip ? 1 : 0;
    }
    EXPECT_LE(skipped, 3);
  }
}

TEST(Assess, FindsSaltedPixels_AndSkipsWhereTheyAreMany) {
  for (const double share : {0.003, 0.01, 0.05}) {
    Watch watch;
    cv::Mat salted = watch.good();
    Rng rng(11, 0);
    for (int i = 0; i < kWidth * kHeight; ++i) {
      if (rng.uniform() < share) {
        salted.data[i] = static_cast<std::uint8_t>(salted.data[i] ^ 0x80U);
      }
    }
    const FrameVerdict verdict = watch.show(salted);
    EXPECT_EQ(verdict.fault, FrameFault::kBitErrors) << share;
    EXPECT_EQ(verdict.decision, FrameDecision::kSkip);
    expect_good(watch.show(watch.good()));
  }
}

TEST(Assess, SkipsBrokenLines) {
  Watch watch;
  cv::Mat broken = watch.good();
  Rng rng(12, 0);
  for (const int row : {31, 57, 88}) {
    for (int u = 0; u < kWidth; ++u) {
      broken.at<std::uint8_t>(row, u) = static_cast<std::uint8_t>(rng.below(256));
    }
  }
  expect_skipped(watch.show(broken), FrameFault::kBitErrors);
}

/// Random octets: as rough, and as sharp, as a picture can be.
cv::Mat random_octets(std::uint64_t seed) {
  cv::Mat gray(kHeight, kWidth, CV_8UC1);
  Rng rng(seed, 0);
  for (int j = 0; j < kWidth * kHeight; ++j) {
    gray.data[j] = static_cast<std::uint8_t>(rng.below(256));
  }
  return gray;
}

TEST(Assess, UsesNoiseThatHasAlwaysBeenThere) {
  QualityHistory history;
  for (std::uint64_t i = 0; i < 10; ++i) {
    expect_good(assess(random_octets(i), {}, &history));
  }
}

TEST(Assess, UsesABlurredFrameWithCare) {
  QualityHistory history;
  for (std::uint64_t i = 0; i < 5; ++i) {
    expect_good(assess(random_octets(i), {}, &history));
  }
  // Means over 9 x 9: neighbours share 8 of 9 columns, those 4 apart 5 of 9, so the change over 1
  // px is sqrt(1 / 4) of that over 4.
  cv::Mat blurred;
  cv::blur(random_octets(9), blurred, cv::Size(9, 9));
  const FrameVerdict verdict = assess(blurred, {}, &history);
  EXPECT_EQ(verdict.fault, FrameFault::kBlurred);
  EXPECT_EQ(verdict.decision, FrameDecision::kCare);
}

TEST(Assess, NeverUsesAPictureThatIsAllAtFullScale_HoweverLong) {
  Watch watch;
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(watch.show(constant(kWidth, kHeight, 255)).decision, FrameDecision::kSkip) << i;
  }
}

TEST(Assess, CallsAPictureWithoutContrastFlat) {
  QualityHistory history;
  expect_skipped(assess(constant(kWidth, kHeight, 128), {}, &history), FrameFault::kFlat);
}

TEST(Assess, SaysTheSame_WhenAskedTheSame) {
  Watch a;
  Watch b;
  for (int i = 0; i < 5; ++i) {
    const FrameVerdict va = a.show(a.good());
    const FrameVerdict vb = b.show(b.good());
    EXPECT_EQ(va.faults, vb.faults);
    EXPECT_EQ(va.measure, vb.measure);
  }
}

}  // namespace
}  // namespace polhode
