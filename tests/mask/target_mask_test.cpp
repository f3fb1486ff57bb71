#include "mask/target_mask.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "base/rng.hpp"
#include "mask/target_levels.hpp"

namespace polhode::target_mask_test {
namespace {

constexpr int kWidth = 200;
constexpr int kHeight = 120;
// Cells are at most kCell_px wide, groups grow by two cells, and a group's edge may lie anywhere in
// its cell.
constexpr int kGrown_px = 3 * TargetMask::kCell_px;

cv::Mat black() {
  cv::Mat gray(kHeight, kWidth, CV_8UC1);
  gray.setTo(0);
  return gray;
}

TargetMask mask_of(const cv::Mat& gray, const MaskOptions& options = {}) {
  TargetMask mask;
  find_target(gray, options, &mask);
  return mask;
}

bool encloses(const cv::Rect& outer, const cv::Rect& inner) { return (outer & inner) == inner; }

// verifies: MSK-01
TEST(FindTarget, EnclosesABrightBodyClosely) {
  const cv::Rect body(57, 31, 46, 53);
  cv::Mat gray = black();
  gray(body).setTo(120);
  const TargetMask mask = mask_of(gray);
  EXPECT_TRUE(encloses(mask.region_px, body));
  const cv::Rect loose(body.x - kGrown_px,
                       body.y - kGrown_px,
                       body.width + 2 * kGrown_px,
                       body.height + 2 * kGrown_px);
  EXPECT_TRUE(encloses(loose, mask.region_px));
  EXPECT_GE(mask.coverage, static_cast<double>(body.area()) / (kWidth * kHeight));
  EXPECT_LE(mask.coverage, static_cast<double>(loose.area()) / (kWidth * kHeight));
}

// verifies: MSK-01
TEST(FindTarget, ContainsEachPixelOfTheBody_AndNoneFarFromIt) {
  const cv::Rect body(57, 31, 46, 53);
  cv::Mat gray = black();
  gray(body).setTo(120);
  const TargetMask mask = mask_of(gray);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const int outside_u = std::max({body.x - u, u - body.br().x + 1, 0});
      const int outside_v = std::max({body.y - v, v - body.br().y + 1, 0});
      if (outside_u == 0 && outside_v == 0) {
        EXPECT_TRUE(mask.contains(u, v)) << u << ", " << v;
      } else if (std::max(outside_u, outside_v) > kGrown_px) {
        EXPECT_FALSE(mask.contains(u, v)) << u << ", " << v;
      }
    }
  }
}

TEST(FindTarget, DropsAStar_WhereverItFallsOnTheCells) {
  for (int phase = 0; phase < 16; ++phase) {
    cv::Mat gray = black();
    gray(cv::Rect(40 + phase % 4, 60 + phase / 4, 3, 3)).setTo(255);  // a star's blur disc
    const TargetMask mask = mask_of(gray);
    EXPECT_TRUE(mask.region_px.empty()) << "phase " << phase % 4 << ", " << phase / 4;
    EXPECT_EQ(mask.coverage, 0.0);
    EXPECT_FALSE(mask.contains(41.0 + phase % 4, 61.0 + phase / 4));
  }
}

TEST(FindTarget, KeepsTheBody_AndDropsTheStarsAroundIt) {
  const cv::Rect body(80, 40, 40, 40);
  cv::Mat gray = black();
  gray(body).setTo(150);
  for (int i = 0; i < 12; ++i) {
    gray.at<std::uint8_t>(8 + 2 * i, 8 + 15 * i) = 255;
  }
  const TargetMask mask = mask_of(gray);
  EXPECT_TRUE(encloses(mask.region_px, body));
  EXPECT_FALSE(mask.contains(8.0, 8.0));
}

TEST(FindTarget, EnclosesAllParts_WhenTheBodyFallsApartInTheImage) {
  const cv::Rect left(20, 30, 30, 30);
  const cv::Rect right(140, 60, 30, 30);
  cv::Mat gray = black();
  gray(left).setTo(150);
  gray(right).setTo(150);
  const TargetMask mask = mask_of(gray);
  EXPECT_TRUE(encloses(mask.region_px, left | right));
  EXPECT_FALSE(mask.contains(95.0, 60.0)) << "what lies between them is empty space";
}

TEST(FindTarget, StaysInsideTheImage_WhenTheBodyTouchesItsEdge) {
  for (const cv::Rect& body :
       {cv::Rect(0, 0, 30, 30), cv::Rect(kWidth - 30, kHeight - 30, 30, 30)}) {
    cv::Mat gray = black();
    gray(body).setTo(150);
    const TargetMask mask = mask_of(gray);
    EXPECT_TRUE(encloses(mask.region_px, body));
    EXPECT_TRUE(encloses(cv::Rect(0, 0, kWidth, kHeight), mask.region_px));
  }
}

TEST(FindTarget, FindsNothing_OnBlackAndOnFaintNoise) {
  cv::Mat gray = black();
  EXPECT_TRUE(mask_of(gray).region_px.empty());
  EXPECT_FALSE(mask_of(gray).contains(50.0, 50.0));
  Rng rng(3, 0);
  for (int i = 0; i < kWidth * kHeight; ++i) {
    gray.data[i] =
        static_cast<std::uint8_t>(rng.below(8));  // at most 7 of 255: under the dark level of 0.03
  }
  EXPECT_TRUE(mask_of(gray).region_px.empty());
}

TEST(FindTarget, TakesTheWholeImage_WhenThereIsNoDarkBackground) {
  cv::Mat gray = black();
  gray.setTo(60);
  const TargetMask mask = mask_of(gray);
  EXPECT_EQ(mask.region_px, cv::Rect(0, 0, kWidth, kHeight));
  EXPECT_DOUBLE_EQ(mask.coverage, 1.0);
}

TEST(FindTarget, TakesTheWholeImage_WhenDisabled) {
  const TargetMask mask = mask_of(black(), {.enabled = false});
  EXPECT_EQ(mask.region_px, cv::Rect(0, 0, kWidth, kHeight));
  EXPECT_DOUBLE_EQ(mask.coverage, 1.0);
  EXPECT_TRUE(mask.contains(0.0, 0.0));
  EXPECT_TRUE(mask.contains(kWidth - 1.0, kHeight - 1.0));
}

TEST(FindTarget, ComparesWithTheDarkLevelThatItIsGiven) {
  cv::Mat gray = black();
  gray(cv::Rect(80, 40, 40, 40)).setTo(51);  // a fifth of full scale
  EXPECT_TRUE(mask_of(gray, {.dark_level = 0.21}).region_px.empty());
  EXPECT_FALSE(mask_of(gray, {.dark_level = 0.19}).region_px.empty());
}

TEST(FindTarget, CoversTheImage_WhenItsSidesAreNoMultipleOfACell) {
  for (int extra = 1; extra < 4; ++extra) {
    cv::Mat gray(64 + extra, 48 + extra, CV_8UC1);
    gray.setTo(99);
    const TargetMask mask = mask_of(gray);
    EXPECT_EQ(mask.region_px, cv::Rect(0, 0, gray.cols, gray.rows));
    EXPECT_TRUE(mask.contains(gray.cols - 1.0, gray.rows - 1.0));
  }
}

TEST(FindTarget, DependsOnNoEarlierImage) {
  TargetMask mask;
  cv::Mat gray = black();
  gray(cv::Rect(80, 40, 40, 40)).setTo(150);
  find_target(gray, {}, &mask);
  find_target(black(), {}, &mask);
  EXPECT_TRUE(mask.region_px.empty());
  EXPECT_EQ(mask.coverage, 0.0);
}

TEST(TargetMask, ContainsNothingOutsideTheImage) {
  const TargetMask mask = mask_of(black(), {.enabled = false});
  EXPECT_FALSE(mask.contains(-1.0, 50.0));
  EXPECT_FALSE(mask.contains(-3.0, 50.0));
  EXPECT_FALSE(mask.contains(50.0, -2.0));
  EXPECT_FALSE(mask.contains(-10.0, 50.0));
  EXPECT_FALSE(mask.contains(kWidth + 4.0, 50.0));
  EXPECT_FALSE(mask.contains(50.0, kHeight + 4.0));
}

TEST(TargetLevels, CountTheTarget_AndNothingAroundIt) {
  cv::Mat gray = black();
  gray(cv::Rect(50, 30, 60, 60)).setTo(120);
  gray.at<std::uint8_t>(5, 5) = 200;
  const TargetMask mask = mask_of(gray);
  const LevelCounts counts = target_levels(gray, {}, mask);
  EXPECT_EQ(counts[120], 3600U);
  EXPECT_EQ(counts[200] + counts[0], 0U);
}

TEST(TargetMask, ContainsNothing_BeforeThereWasAnImage) {
  EXPECT_FALSE(TargetMask{}.contains(0.0, 0.0));
}

}  // namespace
}  // namespace polhode::target_mask_test
