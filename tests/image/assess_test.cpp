#include "image/quality.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

#include "base/rng.hpp"
#include "pictures.hpp"

namespace polhode::assess_test {
namespace {

using namespace images;

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
  cv::Mat good() const { return image(next, static_cast<std::uint64_t>(next)); }
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

// verifies: IMG-02
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

// verifies: IMG-02
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

TEST(Assess, AWhiteFramesRestIsTorn_NotSaturated) {
  const auto lit = [](cv::Mat gray) -> cv::Mat { return gray + cv::Scalar(60); };
  Watch watch(0);
  for (int i = 0; i < 6; ++i) {
    (void)watch.show(lit(watch.good()));
  }
  expect_skipped(watch.show(constant(kWidth, kHeight, 255)), FrameFault::kSaturated);
  cv::Mat torn = lit(watch.good());
  torn.rowRange(60, kHeight).setTo(255);
  expect_skipped(watch.show(torn), FrameFault::kTorn);
  expect_good(watch.show(lit(watch.good())));
}

TEST(Assess, GetsUsedToRowsThatStay_InASceneWithoutNoise) {
  QualityHistory history;
  int skipped = 0;
  FrameVerdict last;
  for (int i = 0; i < 30; ++i) {
    cv::Mat gray = image(0, 1);  // the same noise in each frame: what does not move is equal
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
    cv::Mat gray = image(0, 1);
    gray(cv::Rect(60 + i, 70, 20, 20)).setTo(200);
    (void)assess(gray, {}, &history);
  }
  cv::Mat broken = image(0, 1);  // its rows repeat as always, and a block of it is bytes by chance
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

// verifies: IMG-01
TEST(Assess, NeverUsesADarkImage_HoweverLong) {
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

TEST(Assess, CallsAnImageThatIsAllAtFullScaleSaturated_NotFlat) {
  Watch watch;
  expect_skipped(watch.show(constant(kWidth, kHeight, 255)), FrameFault::kSaturated);
  expect_good(watch.show(watch.good()));
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

/// An image of clouds: outlier pixels, fewer of them the farther out, others in
/// each image.
cv::Mat speckled(std::uint64_t seed, int shift_px) {
  constexpr double kShare = 3e-3;  // by 24 levels and more a third of it
  constexpr double kTypical = 20.0;
  cv::Mat gray(360, 640, CV_8UC1);
  Rng rng(seed, 1);
  for (int v = 0; v < gray.rows; ++v) {
    for (int u = 0; u < gray.cols; ++u) {
      const int cloud =
          70 + 30 * (((u - shift_px) / 40 + v / 30) % 3) + static_cast<int>(rng.below(5));
      const double speck = rng.uniform() < kShare ? -kTypical * std::log(1.0 - rng.uniform()) : 0.0;
      gray.at<std::uint8_t>(v, u) = cv::saturate_cast<std::uint8_t>(cloud + speck);
    }
  }
  return gray;
}

// verifies: IMG-04
TEST(Assess, FindsOneBitInFiveHundredPixels_AmongAsManyOutliers) {
  constexpr unsigned kBitErrors = 1U << static_cast<unsigned>(FrameFault::kBitErrors);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    QualityHistory history;
    const auto faults = [&](const cv::Mat& gray) {
      return assess(gray, {}, &history).faults & kBitErrors;
    };
    const auto clouds = [&](int i) {
      return speckled(100 * seed + static_cast<std::uint64_t>(i), i);
    };
    for (int i = 0; i < 10; ++i) {
      EXPECT_EQ(faults(clouds(i)), 0U) << seed << " " << i;
    }
    cv::Mat salted = clouds(10);
    Rng rng(seed, 2);
    for (int i = 0; i < salted.rows * salted.cols; ++i) {
      if (rng.uniform() < 0.002) {
        salted.data[i] = static_cast<std::uint8_t>(salted.data[i] ^ (1U << rng.below(8)));
      }
    }
    EXPECT_EQ(faults(salted), kBitErrors) << seed;
    EXPECT_EQ(faults(clouds(11)), 0U) << seed;
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

/// Random bytes: as rough, and as sharp, as an image can be.
cv::Mat random_bytes(std::uint64_t seed) {
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
    expect_good(assess(random_bytes(i), {}, &history));
  }
}

// verifies: IMG-03
TEST(Assess, DegradesABlurredFrame) {
  QualityHistory history;
  for (std::uint64_t i = 0; i < 5; ++i) {
    expect_good(assess(random_bytes(i), {}, &history));
  }
  // Means over 9 x 9: neighbours share 8 of 9 columns, those 4 apart 5 of 9, so the change over 1
  // px is sqrt(1 / 4) of that over 4.
  cv::Mat blurred;
  cv::blur(random_bytes(9), blurred, cv::Size(9, 9));
  const FrameVerdict verdict = assess(blurred, {}, &history);
  EXPECT_EQ(verdict.fault, FrameFault::kBlurred);
  EXPECT_EQ(verdict.decision, FrameDecision::kCare);
}

// verifies: IMG-01
TEST(Assess, NeverUsesAnImageThatIsAllAtFullScale_HoweverLong) {
  Watch watch;
  for (int i = 0; i < 40; ++i) {
    EXPECT_EQ(watch.show(constant(kWidth, kHeight, 255)).decision, FrameDecision::kSkip) << i;
  }
}

TEST(Assess, CallsAnImageWithoutContrastFlat) {
  QualityHistory history;
  expect_skipped(assess(constant(kWidth, kHeight, 128), {}, &history), FrameFault::kFlat);
}

TEST(Assess, IsTheSame_ForTheSameFrames) {
  Watch a;
  Watch b;
  const cv::Mat dark = a.good() / 8;
  cv::Mat torn = a.good();
  dark.rowRange(60, kHeight).copyTo(torn.rowRange(60, kHeight));
  int faults = 0;
  for (const cv::Mat& image : {a.good(), dark, dark, torn}) {
    const FrameVerdict va = a.show(image);
    const FrameVerdict vb = b.show(image);
    EXPECT_EQ(va.faults, vb.faults);
    EXPECT_EQ(va.decision, vb.decision);
    EXPECT_EQ(va.measure, vb.measure);
    EXPECT_EQ(va.limit, vb.limit);
    faults += va.faults != 0 ? 1 : 0;
  }
  EXPECT_EQ(faults, 3);
}

TEST(Assess, ComparesWithNothing_AfterItWasCleared) {
  Watch watch;
  const cv::Mat last = watch.history.previous.clone();
  clear(&watch.history);
  expect_good(watch.show(last));
  expect_good(watch.show(last / 8 * 2));  // dark beside frames that were cleared
  expect_skipped(watch.show(last / 8 * 2), FrameFault::kFrozen);
}

}  // namespace
}  // namespace polhode::assess_test
