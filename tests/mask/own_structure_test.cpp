#include "mask/own_structure.hpp"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "mask/mask_state.hpp"
#include "mask/target_mask.hpp"

namespace polhode::own_structure_test {
namespace {

constexpr int kWidth = 200;
constexpr int kHeight = 120;
const cv::Rect kArm(0, 80, 60, 40);    // at rest in the image's corner
const cv::Rect kBody(90, 30, 50, 50);  // apart from it

cv::Mat drawing() {
  cv::Mat pixels = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  pixels(kArm).setTo(255);
  return pixels;
}

cv::Mat image() {
  cv::Mat gray = cv::Mat::zeros(kHeight, kWidth, CV_8UC1);
  gray(kArm).setTo(200);
  gray(kBody).setTo(120);
  return gray;
}

// verifies: MSK-06
TEST(OwnStructure, IsBlackInTheImage_AndNothingElseChanges) {
  const OwnStructure own = own_structure(drawing());
  cv::Mat gray = image();
  blacken(own, &gray);
  EXPECT_EQ(cv::countNonZero(gray(kArm)), 0);
  EXPECT_EQ(cv::countNonZero(gray), kBody.area());
}

// verifies: MSK-06
TEST(OwnStructure, IsNoTarget_AndTheBodyBesideItIs) {
  const OwnStructure own = own_structure(drawing());
  TargetMask mask;
  find_target(image(), {}, &mask);
  ASSERT_TRUE(mask.contains(20, 100));
  close_cells(own, &mask);
  for (int v = kArm.y; v < kHeight; ++v) {
    for (int u = 0; u < kArm.br().x; ++u) {
      EXPECT_FALSE(mask.contains(u, v)) << u << ", " << v;
    }
  }
  EXPECT_TRUE(mask.contains(115, 55));
  EXPECT_GT(mask.region_px.x, kArm.br().x);
}

// verifies: MSK-06
TEST(OwnStructure, ClosesTwoCellsAroundIt_AsItsSilhouetteIsAtRest) {
  const OwnStructure own = own_structure(drawing());
  TargetMask mask;
  find_target(image(), {.enabled = false}, &mask);
  close_cells(own, &mask);
  constexpr int kTwoCells_px = 2 * TargetMask::kCell_px;
  EXPECT_FALSE(mask.contains(kArm.br().x + kTwoCells_px - 1, 100));
  EXPECT_TRUE(mask.contains(kArm.br().x + kTwoCells_px, 100));
  EXPECT_FALSE(mask.contains(20, kArm.y - kTwoCells_px));
  EXPECT_TRUE(mask.contains(20, kArm.y - kTwoCells_px - 1));
}

// verifies: MSK-06
TEST(OwnStructure, HasNoPointsAndNoOutline) {
  const OwnStructure own = own_structure(drawing());
  MaskState state;
  state.outline = cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
  for (const cv::Point2f at :
       {cv::Point2f(20.0F, 100.0F), cv::Point2f(63.0F, 100.0F), cv::Point2f(115.0F, 55.0F)}) {
    MaskTrack track;
    track.places[0] = at;
    track.count = 1;
    (void)state.points.tracks.push_back(track);
  }
  leave_out(own, &state);
  ASSERT_EQ(state.points.tracks.size(), 1U);  // that along the silhouette is gone, too
  EXPECT_EQ(state.points.tracks[0].now(), cv::Point2f(115.0F, 55.0F));
  EXPECT_EQ(state.outline.at<std::uint8_t>(100, 20), 0);
  EXPECT_EQ(state.outline.at<std::uint8_t>(55, 115), 255);
}

TEST(OwnStructure, IsReducedAsImagesAre) {
  // 1366 x 770: a quarter of it is 341.5 x 192.5, and the working image leaves out what is
  // beyond.
  cv::Mat pixels = cv::Mat::zeros(770, 1366, CV_8UC1);
  pixels.at<std::uint8_t>(769, 1365) = 1;
  const OwnStructure own = own_structure(pixels);
  const int decimation = decimation_of(1366, 770);
  EXPECT_EQ(own.cells.size(), cv::Size(342, 193));
  EXPECT_EQ(own.working.size(), cv::Size(1366 / decimation, 770 / decimation));
  EXPECT_EQ(own.cells.at<std::uint8_t>(192, 341), 255);
}

}  // namespace
}  // namespace polhode::own_structure_test
