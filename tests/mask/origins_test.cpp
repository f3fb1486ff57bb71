// Where an image's pixels come from.
#include "mask/origins.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace polhode::origins_test {
namespace {

const cv::Size kSize(160, 120);
const cv::Rect kRegion(16, 24, 101, 77);

/// Pixels are numbered.
cv::Mat image() {
  cv::Mat numbers(kSize, CV_16UC1);
  std::iota(numbers.begin<std::uint16_t>(), numbers.end<std::uint16_t>(), std::uint16_t{0});
  return numbers;
}

cv::Mat seen_through(const cv::Matx33d& motion, const cv::Rect& region) {
  Origins origins;
  cv::Mat out;
  trace_plane(motion, region, kSize, &origins);
  look_up(image(), origins, &out);
  return out;
}

TEST(TracePlane, IsTheLibrarysWarp_ToTheNearestPixel) {
  const cv::Matx33d motion(1.02, -0.03, 2.3, 0.02, 0.99, -1.6, 1E-4, -2E-4, 1.0);
  cv::Mat warped;
  cv::warpPerspective(image(), warped, motion, kSize, cv::INTER_NEAREST, cv::BORDER_REPLICATE);
  const cv::Mat found = seen_through(motion, kRegion);
  ASSERT_EQ(found.size(), kRegion.size());
  EXPECT_LT(cv::mean(found != warped(kRegion))[0] / 255.0, 0.05)
      << "halves are rounded in another way";
}

TEST(TracePlane, RepeatsTheBorder_OutsideOfTheImage_HoweverFar) {
  for (const double shift_px : {30.0, 3E4, 1E12}) {
    const cv::Mat found = seen_through({1, 0, shift_px, 0, 1, 0, 0, 0, 1}, {0, 0, 20, 120});
    EXPECT_EQ(cv::norm(found.col(3), image().col(0), cv::NORM_INF), 0.0) << shift_px;
  }
}

TEST(TracePlane, StaysInTheImage_WhereAPlaneIsSeenFromItsEdge) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const cv::Matx33d& motion :
       {cv::Matx33d(1, 0, 0, 0, 1, 0, -0.02, 0, 1), cv::Matx33d::zeros(), cv::Matx33d::all(nan)}) {
    Origins origins;
    trace_plane(motion, kRegion, kSize, &origins);
    double least = 0.0;
    double most = 0.0;
    cv::minMaxLoc(origins.index, &least, &most);
    EXPECT_GE(least, 0.0);
    EXPECT_LT(most, kSize.area());
  }
}

constexpr int kCell_px = 8;

cv::Mat steady(const cv::Point2f& flow_px) {
  const cv::Size grid(kSize.width / kCell_px, kSize.height / kCell_px);
  return {grid, CV_32FC2, cv::Scalar(flow_px.x, flow_px.y)};
}

TEST(TraceFlow, BringsBackWhatHasMoved) {
  Origins origins;
  cv::Mat found;
  trace_flow(steady({6.3F, -4.2F}), kCell_px, kRegion, kSize, &origins);
  look_up(image(), origins, &found);
  const cv::Rect there(kRegion.tl() - cv::Point(6, -4), kRegion.size());
  ASSERT_EQ(found.size(), kRegion.size());
  EXPECT_EQ(cv::norm(found, image()(there), cv::NORM_INF), 0.0);
}

TEST(Carry, BringsAlongWhatIsKnown_BetweenCells_ByPixelsAndByCells) {
  for (const int step : {1, 2}) {
    const cv::Size size = kSize / step;
    cv::Mat ramp(size, CV_32FC1);
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        ramp.at<float>(row, column) = static_cast<float>(column + 0.5 * row);
      }
    }
    cv::Mat from;
    cv::Mat found;
    carry(steady({3.0F, -2.0F}), {kRegion, step, kCell_px}, ramp, &from, &found);
    ASSERT_EQ(found.size(),
              cv::Size((kRegion.width + step - 1) / step, (kRegion.height + step - 1) / step));
    const cv::Mat here = ramp(cv::Rect(kRegion.tl() / step, found.size()));
    const cv::Mat come = here - found;  // 3 px to the right and 2 px up
    EXPECT_NEAR(cv::norm(come - 2.0 / step, cv::NORM_INF), 0.0, 0.04) << step;
  }
}

TEST(Carry, RepeatsTheBorder_OutsideOfWhatIsKnown) {
  cv::Mat known(kSize, CV_32FC1, cv::Scalar(1.0));
  known.col(0).setTo(5.0);
  cv::Mat from;
  cv::Mat found;
  carry(steady({40.0F, 0.0F}), {{0, 0, 40, 120}, 1, kCell_px}, known, &from, &found);
  EXPECT_EQ(cv::norm(found, cv::NORM_INF), 5.0);
  EXPECT_EQ(cv::countNonZero(found == 5.0), found.size().area());
}

}  // namespace
}  // namespace polhode::origins_test
