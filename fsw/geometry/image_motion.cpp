#include "geometry/image_motion.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstddef>
#include <limits>

#include "base/assert.hpp"
#include "base/fixed_vector.hpp"
#include "base/median.hpp"
#include "base/validity.hpp"
#include "config/limits.hpp"

namespace polhode {
namespace {

using Terms = Eigen::Matrix<double, 6, 1>;

/// Terms of the quadratic, of which the first `count` take part: 1, 3 or 6.
Terms terms_at(const ImageMotion& motion, const Eigen::Vector2d& normalised, std::size_t count) {
  const Eigen::Vector2d at =
      (normalised - motion.centre).cwiseQuotient(motion.reach).cwiseMax(-1.0).cwiseMin(1.0);
  const double x = at.x();
  const double y = at.y();
  Terms terms;
  terms << 1.0, x, y, x * x, x * y, y * y;
  terms.tail(static_cast<Eigen::Index>(6 - count)).setZero();
  return terms;
}

std::size_t term_count(std::size_t points) {
  // Least points per term: with half of them wrong two are left.
  constexpr std::size_t kPointsOfTerm = 4;
  return points >= 6 * kPointsOfTerm ? 6 : points >= 3 * kPointsOfTerm ? 3 : 1;
}

void set_box(std::span<const MovingPoint> points, ImageMotion* motion) {
  Eigen::Vector2d least = points[0].normalised;
  Eigen::Vector2d most = least;
  for (const MovingPoint& point : points) {
    least = least.cwiseMin(point.normalised);
    most = most.cwiseMax(point.normalised);
  }
  motion->centre = 0.5 * (least + most);
  motion->reach = (0.5 * (most - least)).cwiseMax(std::numeric_limits<double>::min());
}

}  // namespace

Eigen::Vector2d velocity_at(const ImageMotion& motion, const Eigen::Vector2d& normalised) {
  return motion.coefficients_per_s * terms_at(motion, normalised, 6);
}

ImageMotion fit_image_motion(std::span<const MovingPoint> points) {
  POLHODE_ASSERT(points.size() <= limits::kFeatures, points.size());
  ImageMotion motion;
  if (points.empty()) {
    return motion;
  }
  set_box(points, &motion);
  const std::size_t count = term_count(points.size());
  const auto active = static_cast<Eigen::Index>(count);
  FixedVector<double, limits::kFeatures> distances;
  double scale = 0.0;         // of the residuals; zero: all weights are one
  constexpr int kRounds = 6;  // the first is not robust; weights settle within five more
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 2> right = Eigen::Matrix<double, 6, 2>::Zero();
    for (const MovingPoint& point : points) {
      const Terms terms = terms_at(motion, point.normalised, count);
      const double off = (point.velocity_per_s - motion.coefficients_per_s * terms).squaredNorm();
      const double weight = scale > 0.0 ? 1.0 / (1.0 + off / (scale * scale)) : 1.0;
      normal += weight * terms * terms.transpose();
      right += weight * terms * point.velocity_per_s.transpose();
    }
    // A ridge: points on a line leave the direction across it undetermined.
    normal.diagonal().array() += 1e-9 * normal(0, 0);
    const Eigen::Matrix<double, 2, 6> solved = normal.ldlt().solve(right).transpose();
    motion.coefficients_per_s.setZero();
    motion.coefficients_per_s.leftCols(active) = solved.leftCols(active);
    distances.clear();
    for (const MovingPoint& point : points) {
      (void)distances.push_back(
          (point.velocity_per_s - velocity_at(motion, point.normalised)).norm());
    }
    scale = median(distances.view());
  }
  return validity::is_bounded(motion.coefficients_per_s) ? motion : ImageMotion{};
}

double row_delay_s(const CameraModel& camera, double v_px) {
  return camera.line_time_s * (v_px - 0.5 * static_cast<double>(camera.height_px - 1));
}

Eigen::Vector2d at_frame_time(const CameraModel& camera,
                              const ImageMotion& motion,
                              const Eigen::Vector2d& pixel) {
  Eigen::Vector2d point = undistort(camera, pixel);
  if (camera.line_time_s != 0.0) {
    point -= row_delay_s(camera, pixel.y()) * velocity_at(motion, point);
  }
  return point;
}

}  // namespace polhode
