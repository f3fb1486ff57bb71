#include "mask/plane_motion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/assert.hpp"
#include "base/consensus.hpp"

namespace polhode {
namespace {

using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;

// Part of the fits that may miss a sample of four agreeing points.
constexpr double kMiss = 0.01;
// Enough for kMiss where 46 % of the points agree: ln(0.01) / ln(1 - 0.46^4) = 100.
constexpr int kDrawsMax = 100;
// Twice the four points that any homography fits.
constexpr std::size_t kAgreeMin = 8;
// Coordinates in hundreds of pixels keep the equations' terms of one size.
constexpr double kUnit_px = 100.0;

/// Two equations of a homography by one pair of points, linear in its eight unknowns (the ninth
/// element is 1): row * unknowns = u, or v.
struct PairEquations {
  Vector8d row_u, row_v;
  double u = 0.0, v = 0.0;
};

PairEquations equations_of(const cv::Point2f& from, const cv::Point2f& to) {
  const double x = static_cast<double>(from.x) / kUnit_px;
  const double y = static_cast<double>(from.y) / kUnit_px;
  PairEquations e;
  e.u = static_cast<double>(to.x) / kUnit_px;
  e.v = static_cast<double>(to.y) / kUnit_px;
  e.row_u << x, y, 1.0, 0.0, 0.0, 0.0, -e.u * x, -e.u * y;
  e.row_v << 0.0, 0.0, 0.0, x, y, 1.0, -e.v * x, -e.v * y;
  return e;
}

/// The homography between pixels, by its unknowns in units of kUnit_px.
cv::Matx33d in_pixels(const Vector8d& h) {
  return {h(0),
          h(1),
          h(2) * kUnit_px,
          h(3),
          h(4),
          h(5) * kUnit_px,
          h(6) / kUnit_px,
          h(7) / kUnit_px,
          1.0};
}

/// The homography through the sample's four pairs of points; nothing where it is not finite.
std::optional<cv::Matx33d> through_four(std::span<const cv::Point2f> from,
                                        std::span<const cv::Point2f> to,
                                        const Sample<4>& sample) {
  Matrix8d A;
  Vector8d b;
  for (int i = 0; i < 4; ++i) {
    const std::size_t k = sample[static_cast<std::size_t>(i)];
    const PairEquations e = equations_of(from[k], to[k]);
    A.row(2 * i) = e.row_u.transpose();
    A.row(2 * i + 1) = e.row_v.transpose();
    b(2 * i) = e.u;
    b(2 * i + 1) = e.v;
  }
  const Vector8d h = A.partialPivLu().solve(b);
  return h.allFinite() ? std::optional(in_pixels(h)) : std::nullopt;
}

/// Sum of squared distances, each truncated at fit_px^2. Stops when it is over `enough`.
double score(std::span<const cv::Point2f> from,
             std::span<const cv::Point2f> to,
             const cv::Matx33d& motion,
             double fit_px,
             double enough) {
  const auto limit = static_cast<float>(fit_px * fit_px);
  double sum = 0.0;
  for (std::size_t i = 0; i < from.size() && sum < enough; ++i) {
    const cv::Point2f d = moved(motion, from[i]) - to[i];
    const float e2 = d.x * d.x + d.y * d.y;
    sum += static_cast<double>(e2 < limit ? e2 : limit);  // NaN counts as far
  }
  return sum;
}

/// Least squares on the points that agree with `motion`, which is replaced.
void refine(std::span<const cv::Point2f> from,
            std::span<const cv::Point2f> to,
            double fit_px,
            cv::Matx33d* motion) {
  const auto limit = static_cast<float>(fit_px * fit_px);
  Matrix8d normal = Matrix8d::Zero();
  Vector8d right = Vector8d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    const cv::Point2f d = moved(*motion, from[i]) - to[i];
    if (d.x * d.x + d.y * d.y < limit) {
      const PairEquations e = equations_of(from[i], to[i]);
      normal += e.row_u * e.row_u.transpose() + e.row_v * e.row_v.transpose();
      right += e.u * e.row_u + e.v * e.row_v;
    }
  }
  const Vector8d h = normal.ldlt().solve(right);
  if (h.allFinite()) {
    *motion = in_pixels(h);
  }
}

}  // namespace

cv::Point2f moved(const cv::Matx33d& motion, const cv::Point2f& point) {
  const auto x = static_cast<double>(point.x);
  const auto y = static_cast<double>(point.y);
  const double w = motion(2, 0) * x + motion(2, 1) * y + motion(2, 2);
  return {static_cast<float>((motion(0, 0) * x + motion(0, 1) * y + motion(0, 2)) / w),
          static_cast<float>((motion(1, 0) * x + motion(1, 1) * y + motion(1, 2)) / w)};
}

bool fit_plane_motion(std::span<const cv::Point2f> from,
                      std::span<const cv::Point2f> to,
                      double fit_px,
                      cv::Matx33d* motion,
                      std::vector<std::uint8_t>* agrees) {
  POLHODE_ASSERT(from.size() == to.size(), from.size());
  if (from.size() < kAgreeMin) {
    return false;
  }
  BestHypothesis<cv::Matx33d> best;
  find_consensus<4>(
      {.points = from.size(),
       .draws_max = kDrawsMax,
       .stream = from.size(),
       .missed = kMiss,
       .score_of_none = fit_px * fit_px * static_cast<double>(from.size())},
      [&](const Sample<4>& sample) { return through_four(from, to, sample); },
      [&](const cv::Matx33d* m, double enough) { return score(from, to, *m, fit_px, enough); },
      &best);
  if (!best.found()) {
    return false;
  }
  *motion = best.model;
  // Each round may change which points agree. Chosen; more cost time and change little.
  constexpr int kRounds = 3;
  for (int i = 0; i < kRounds; ++i) {
    refine(from, to, fit_px, motion);
  }
  agrees->assign(from.size(), 0);
  std::size_t count = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const cv::Point2f d = moved(*motion, from[i]) - to[i];
    (*agrees)[i] = std::hypot(d.x, d.y) < static_cast<float>(fit_px) ? 1 : 0;
    count += (*agrees)[i];
  }
  return count >= kAgreeMin;
}

}  // namespace polhode
