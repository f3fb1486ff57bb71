#include "opencv_sift.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace polhode::benchmark {
namespace {

/// The region at the scale that detection works on.
struct Resampled {
  cv::Mat image;
  double factor_u = 1.0;  ///< working pixels per image pixel
  double factor_v = 1.0;
};

/// A small region is enlarged: its finest texture lies under the detector's smallest blob, and at
/// twice the size three times as many spots repeat from frame to frame, at the same accuracy. More
/// than twice brings interpolation, not texture.
Resampled resample(const cv::Mat& region, int pixels_max) {
  constexpr double kEnlargeMax = 2.0;
  const double factor =
      std::min(kEnlargeMax,
               std::sqrt(static_cast<double>(pixels_max) / static_cast<double>(region.total())));
  const cv::Size size(static_cast<int>(region.cols * factor),
                      static_cast<int>(region.rows * factor));
  Resampled r;
  cv::resize(region, r.image, size, 0.0, 0.0, factor > 1.0 ? cv::INTER_CUBIC : cv::INTER_AREA);
  r.factor_u = static_cast<double>(size.width) / region.cols;
  r.factor_v = static_cast<double>(size.height) / region.rows;
  return r;
}

/// The strongest of each cell of a grid first, then the second strongest, so that no bright corner
/// takes all places.
std::vector<cv::KeyPoint> spread(const std::vector<cv::KeyPoint>& points,
                                 const cv::Size& size,
                                 std::size_t count) {
  constexpr int kGrid = 8;
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    const cv::KeyPoint& a = points[i];
    const cv::KeyPoint& b = points[j];
    return a.response != b.response ? a.response > b.response
                                    : (a.pt.y != b.pt.y ? a.pt.y < b.pt.y : a.pt.x < b.pt.x);
  });
  std::array<int, kGrid * kGrid> taken{};
  std::vector<int> rank(points.size());
  for (const std::size_t i : order) {
    const cv::Point2f& at = points[i].pt;
    const int column =
        std::clamp(static_cast<int>(at.x * kGrid / static_cast<float>(size.width)), 0, kGrid - 1);
    const int row =
        std::clamp(static_cast<int>(at.y * kGrid / static_cast<float>(size.height)), 0, kGrid - 1);
    rank[i] = taken[static_cast<std::size_t>(row * kGrid + column)]++;
  }
  std::stable_sort(
      order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank[a] < rank[b]; });
  std::vector<cv::KeyPoint> chosen;
  for (std::size_t i = 0; i < std::min(count, order.size()); ++i) {
    chosen.push_back(points[order[i]]);
  }
  return chosen;
}

Descriptor to_root_sift(const float* row) {
  float sum = 0.0F;
  for (std::size_t i = 0; i < 128; ++i) {
    sum += row[i];
  }
  const float inverse = sum > 0.0F ? 1.0F / sum : 0.0F;
  Descriptor d;
  for (std::size_t i = 0; i < 128; ++i) {
    d[i] = static_cast<std::uint8_t>(std::min(255.0F, 512.0F * std::sqrt(row[i] * inverse) + 0.5F));
  }
  return d;
}

Feature to_feature(const cv::KeyPoint& point,
                   const cv::Rect& region,
                   const Resampled& working,
                   double sigma_px) {
  // OpenCV's SIFT doubles the image by bilinear resize, whose pixel (2x, 2y) is centred a quarter
  // pixel short of (x, y), and halves the coordinates without giving that back.
  constexpr double kDoublingShift_px = 0.25;
  Feature f;
  const double x = static_cast<double>(point.pt.x) - kDoublingShift_px;
  const double y = static_cast<double>(point.pt.y) - kDoublingShift_px;
  f.u_px = static_cast<float>((x + 0.5) / working.factor_u - 0.5 + region.x);
  f.v_px = static_cast<float>((y + 0.5) / working.factor_v - 0.5 + region.y);
  f.scale_px = static_cast<float>(0.5 * static_cast<double>(point.size) / working.factor_u);
  f.angle_rad = point.angle * std::numbers::pi_v<float> / 180.0F;
  // A blob's position is uncertain in proportion to its size; the finest ones (radius 1.6 px) are
  // held by pixel noise.
  const double coarseness = std::max(1.0, static_cast<double>(f.scale_px) / 2.0);
  f.sigma_px = static_cast<float>(sigma_px * std::sqrt(coarseness));
  return f;
}

}  // namespace

void detect_features_opencv(const cv::Mat& gray,
                            const TargetMask& mask,
                            const CameraModel& camera,
                            const FeatureOptions& options,
                            Features* features) {
  features->clear();
  const cv::Rect region = mask.region_px;
  constexpr int kSide_px_min = 16;
  if (region.width < kSide_px_min || region.height < kSide_px_min) {
    return;
  }
  const Resampled working = resample(gray(region), options.working_pixels_max);
  constexpr int kOctaveLayers = 3;
  constexpr double kEdgeThreshold = 10.0;
  constexpr double kSigma = 1.6;
  const cv::Ptr<cv::SIFT> sift = cv::SIFT::create(
      0, kOctaveLayers, options.contrast_min * kOctaveLayers, kEdgeThreshold, kSigma);
  std::vector<cv::KeyPoint> points;
  sift->detect(working.image, points);
  std::erase_if(points, [&](const cv::KeyPoint& p) {
    return !mask.contains(static_cast<double>(p.pt.x) / working.factor_u + region.x,
                          static_cast<double>(p.pt.y) / working.factor_v + region.y);
  });
  points = spread(points, working.image.size(), static_cast<std::size_t>(options.count_max));
  cv::Mat rows;
  sift->compute(working.image, points, rows);
  for (std::size_t i = 0; i < points.size(); ++i) {
    Feature f = to_feature(points[i], region, working, options.sigma_px);
    f.normalised = undistort(camera, {f.u_px, f.v_px});
    f.descriptor = to_root_sift(rows.ptr<float>(static_cast<int>(i)));
    if (!features->push_back(f)) {
      break;
    }
  }
}

}  // namespace polhode::benchmark
