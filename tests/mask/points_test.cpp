// Points followed for the mask: where they go, and where new ones are looked for.
#include "mask/points.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "base/rng.hpp"
#include "moving_scene.hpp"

namespace polhode::points_test {
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

/// The part of a blurred random image that starts at a place.
cv::Mat view_from(const cv::Point& place) {
  cv::Mat all(kSize + cv::Size(100, 100), CV_8UC1);
  Rng rng(9, 0);
  for (int row = 0; row < all.rows; ++row) {
    for (int column = 0; column < all.cols; ++column) {
      all.at<std::uint8_t>(row, column) = static_cast<std::uint8_t>(rng.below(256));
    }
  }
  cv::GaussianBlur(all, all, cv::Size(0, 0), 4.0);
  cv::normalize(all, all, 20.0, 230.0, cv::NORM_MINMAX);
  return all(cv::Rect(place, kSize)).clone();
}

/// Part of the points that moved so in the newest image, to half a pixel.
double part_moved(const PointsState& points, const cv::Point2f& motion_px) {
  const auto moved =
      std::count_if(points.tracks.begin(), points.tracks.end(), [&](const MaskTrack& track) {
        return track.count > 1 && cv::norm(track.motion(1) - motion_px) < 0.5;
      });
  return static_cast<double>(moved) / static_cast<double>(points.tracks.size());
}

class FollowPoints : public testing::TestWithParam<bool> {
 protected:
  void show(const cv::Point& place) {
    add_image(view_from(place), {}, &points_);
    follow_points(&points_);
  }

  PointsState points_;
};

INSTANTIATE_TEST_SUITE_P(FromWhereTheyWereAndPredicted, FollowPoints, testing::Values(false, true));

TEST_P(FollowPoints, FollowsTheImage_AndAMotionThatChangesAtOnce) {
  points_.predicted = GetParam();
  show({0, 0});
  refill_points({}, Refill::kEverywhere, &points_);
  show({2, 1});
  show({4, 2});
  EXPECT_GT(part_moved(points_, {-2.0F, -1.0F}), 0.95);
  show({18, 12});  // 15 px from where that would have brought them
  EXPECT_GT(part_moved(points_, {-14.0F, -10.0F}), 0.9);
  show({32, 22});
  EXPECT_GT(part_moved(points_, {-14.0F, -10.0F}), 0.9);
  EXPECT_GT(points_.tracks.size(), 100U);
}

TEST_P(FollowPoints, DropsWhatDoesNotComeBackToWhereItWas) {
  points_.predicted = GetParam();
  show({0, 0});
  refill_points({}, Refill::kEverywhere, &points_);
  show({2, 1});
  const std::size_t all = points_.tracks.size();
  for (std::size_t i = 0; i < all; i += 4) {
    points_.tracks[i].places[0] += cv::Point2f(3.0F, -2.0F);  // mistracked
  }
  drop_stray_points(TrackClass::kUnassigned, &points_);
  EXPECT_GE(points_.tracks.size(), all * 7 / 10);
  EXPECT_GT(part_moved(points_, {-2.0F, -1.0F}), 0.98);
}

TEST(AddPicture, TakesWhatIsReducedAlready_WhereItIsTheSame) {
  const cv::Mat gray =
      moving::texture(1280, 3)(cv::Rect(0, 0, 1280, 960));  // two pixels a working one
  cv::Mat halved;
  cv::resize(gray, halved, gray.size() / 2, 0.0, 0.0, cv::INTER_AREA);
  cv::Mat quarter;
  cv::resize(halved, quarter, gray.size() / 4, 0.0, 0.0, cv::INTER_AREA);
  const cv::Mat marked = ~halved;  // to be distinguished from what would be computed
  const auto stored = [&](const cv::Mat& reduced) {
    PointsState points;
    EXPECT_TRUE(add_image(gray, reduced, &points));
    EXPECT_NE(points.image(0).data, reduced.data);
    return points.image(0).clone();
  };
  EXPECT_EQ(cv::norm(stored({}), halved, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(stored(quarter), halved, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(stored(marked), marked, cv::NORM_INF), 0.0);
}

TEST(RefillPoints, CoversTheImageAtOnce_AndTheTargetCloser) {
  PointsState points;
  add_image(spots(), {}, &points);
  refill_points(kTarget, Refill::kEverywhere, &points);
  EXPECT_GT(count_on_target(points), 100U);
  EXPECT_GT(points.tracks.size(), count_on_target(points) + 100U);
}

TEST(RefillPoints, FillsTheTargetInEachImage_WhileItHasFewPoints) {
  PointsState points;
  add_image(spots(), {}, &points);
  for (int image = 0; image < 4; ++image) {
    points.tracks.clear();
    refill_points(kTarget, Refill::kByTurns, &points);
    EXPECT_GT(count_on_target(points), 80U) << image;
  }
}

TEST(RefillPoints, AnyPlaceHasBeenLookedAt_AfterFourImages_OrEightByTurns) {
  for (const auto& [where, images] :
       {std::pair(Refill::kBandAndTarget, 4), std::pair(Refill::kByTurns, 8)}) {
    PointsState points;
    add_image(spots(), {}, &points);
    refill_points(kTarget, Refill::kEverywhere, &points);
    const std::size_t full = points.tracks.size();
    const std::size_t full_on_target = count_on_target(points);
    lose_upper_half(&points);
    ASSERT_LT(count_on_target(points), full_on_target * 3 / 4);
    for (int image = 0; image < images; ++image) {
      refill_points(kTarget, where, &points);
    }
    EXPECT_GE(count_on_target(points), full_on_target * 9 / 10) << images;
    points.tracks.clear();
    for (int image = 0; image < images; ++image) {
      refill_points({}, where, &points);
    }
    EXPECT_GT(points.tracks.size(), (full - full_on_target) * 9 / 10) << images;
  }
}

}  // namespace
}  // namespace polhode::points_test
