// Where a picture's pixels come from.
#include "mask/origins.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "moving_scene.hpp"

namespace polhode {
namespace {

const cv::Size kSize(160, 120);
const cv::Rect kRegion(16, 24, 101, 77);

cv::Mat picture() { return moving::texture(200, 7)(cv::Rect(cv::Point(), kSize)).clone(); }

cv::Mat seen_through(const cv::Matx33d& motion, const cv::Rect& region) {
  Origins origins;
  cv::Mat out;
  trace_plane(motion, region, kSize, &origins);
  look_up(picture(), origins, &out);
  return out;
}

TEST(TracePlane, IsTheLibrarysWarp_WithinAGridOfThirtySeconds) {
  const cv::Matx33d motion(1.02, -0.03, 2.3, 0.02, 0.99, -1.6, 1E-4, -2E-4, 1.0);
  cv::Mat warped;
  cv::warpPerspective(picture(), warped, motion, kSize, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  const cv::Mat found = seen_through(motion, kRegion);
  ASSERT_EQ(found.size(), kRegion.size());
  EXPECT_LT(cv::mean(found != warped(kRegion))[0] / 255.0, 0.02) << "ties are rounded in another way";
  EXPECT_LE(cv::norm(found, warped(kRegion), cv::NORM_INF), 4.0);
}

TEST(TracePlane, RepeatsTheRim_OutsideOfThePicture_HoweverFar) {
  for (const double shift_px : {30.0, 3E4, 1E12}) {
    const cv::Mat found = seen_through({1, 0, shift_px, 0, 1, 0, 0, 0, 1}, {0, 0, 20, 120});
    EXPECT_EQ(cv::norm(found.col(3), picture().col(0), cv::NORM_INF), 0.0) << shift_px;
  }
}

TEST(TracePlane, StaysNearThePicture_WhereAPlaneIsSeenFromItsEdge) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const cv::Matx33d& motion : {cv::Matx33d(1, 0, 0, 0, 1, 0, -0.02, 0, 1), cv::Matx33d::zeros(), cv::Matx33d::all(nan)}) {
    Origins origins;
    trace_plane(motion, kRegion, kSize, &origins);
    std::vector<cv::Mat> along(2);
    cv::split(origins.pixel, along);
    EXPECT_TRUE(cv::checkRange(along[0], true, nullptr, -8.0, kSize.width + 9.0));
    EXPECT_TRUE(cv::checkRange(along[1], true, nullptr, -8.0, kSize.height + 9.0));
  }
}

TEST(TraceFlow, BringsBackWhatHasMoved_ByPixelsAndByCells) {
  constexpr int kCell_px = 8;
  const cv::Size grid(kSize.width / kCell_px, kSize.height / kCell_px);
  const cv::Mat flow(grid, CV_32FC2, cv::Scalar(6.0, -4.0));
  for (const int step : {1, 2}) {
    cv::Mat before;
    cv::resize(picture(), before, kSize / step, 0.0, 0.0, cv::INTER_AREA);
    Origins origins;
    cv::Mat found;
    trace_flow(flow, kCell_px, kRegion, step, before.size(), &origins);
    look_up(before, origins, &found);
    const cv::Point from = kRegion.tl() / step - cv::Point(6, -4) / step;
    const cv::Rect there(from, found.size());
    ASSERT_EQ(found.size(), cv::Size((kRegion.width + step - 1) / step, (kRegion.height + step - 1) / step));
    EXPECT_EQ(cv::norm(found, before(there), cv::NORM_INF), 0.0) << step;
  }
}

}  // namespace
}  // namespace polhode
