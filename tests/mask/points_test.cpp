// Points followed for the mask: where new ones are looked for.
#include "mask/points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "base/rng.hpp"

namespace polhode {
namespace {

const cv::Size kSize(320, 240);
const cv::Rect kTarget(100, 80, 120, 80);

/// Spots 3 px across all over: corners wherever they are looked for.
cv::Mat spots() {
  cv::Mat gray(kSize, CV_8UC1, cv::Scalar(60));
  Rng rng(5, 0);
  for (int row = 0; row + 3 <= kSize.height; row += 6) {
    for (int column = 0; column + 3 <= kSize.width; column += 6) {
      gray(cv::Rect(column, row, 3, 3)).setTo(140.0 + 30.0 * rng.normal());
    }
  }
  return gray;
}

std::size_t count_on_target(const PointsState& points) {
  return static_cast<std::size_t>(
      std::count_if(points.tracks.begin(), points.tracks.end(), [](const MaskTrack& track) {
        return kTarget.contains(cv::Point(track.now()));
      }));
}

/// Takes all points of the upper half of the target away: half of them stay.
void lose_upper_half(PointsState* points) {
  std::size_t kept = 0;
  for (const MaskTrack& track : points->tracks) {
    const cv::Point at(track.now());
    if (!kTarget.contains(at) || at.y >= kTarget.y + kTarget.height / 2) {
      points->tracks[kept++] = track;
    }
  }
  points->tracks.resize(kept);
}

TEST(RefillPoints, CoversThePictureAtOnce_AndTheTargetCloser) {
  PointsState points;
  add_picture(spots(), &points);
  refill_points(kTarget, Refill::kEverywhere, &points);
  EXPECT_GT(count_on_target(points), 100U);
  EXPECT_GT(points.tracks.size(), count_on_target(points) + 100U);
}

TEST(RefillPoints, FillsTheTargetInEachPicture_WhileItHasFewPoints) {
  PointsState points;
  add_picture(spots(), &points);
  for (int picture = 0; picture < 4; ++picture) {
    points.tracks.clear();
    refill_points(kTarget, Refill::kByTurns, &points);
    EXPECT_GT(count_on_target(points), 80U) << picture;
  }
}

TEST(RefillPoints, AnyPlaceHasBeenLookedAt_AfterFourPictures_OrEightByTurns) {
  for (const auto& [where, pictures] : {std::pair(Refill::kBandAndTarget, 4), std::pair(Refill::kByTurns, 8)}) {
    PointsState points;
    add_picture(spots(), &points);
    refill_points(kTarget, Refill::kEverywhere, &points);
    const std::size_t full = points.tracks.size();
    const std::size_t full_on_target = count_on_target(points);
    lose_upper_half(&points);
    ASSERT_LT(count_on_target(points), full_on_target * 3 / 4);
    for (int picture = 0; picture < pictures; ++picture) {
      refill_points(kTarget, where, &points);
    }
    EXPECT_GE(count_on_target(points), full_on_target * 9 / 10) << pictures;
    points.tracks.clear();
    for (int picture = 0; picture < pictures; ++picture) {
      refill_points({}, where, &points);
    }
    EXPECT_GT(points.tracks.size(), (full - full_on_target) * 9 / 10) << pictures;
  }
}

}  // namespace
}  // namespace polhode
