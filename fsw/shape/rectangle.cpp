#include "shape/rectangle.hpp"

#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "base/fixed_vector.hpp"
#include "base/median.hpp"
#include "config/limits.hpp"

namespace polhode {
namespace {

// Quantile cut off at either end. Chosen: larger tolerates more stragglers, smaller depends less on
// an even spread of the values.
constexpr double kTail = 0.02;
// Directions of half a degree each over a quarter turn: an edge is too long by 0.4 % of the other
// at most.
constexpr int kDirections = 180;

using Values = FixedVector<double, limits::kCloudPoints>;

Extent extent_along(std::span<const Eigen::Vector2d> points,
                    const Eigen::Vector2d& direction,
                    Values& scratch) {
  scratch.clear();
  for (const Eigen::Vector2d& point : points) {
    POLHODE_ASSERT(scratch.push_back(direction.dot(point)), scratch.size());
  }
  return robust_extent(scratch.view());
}

Eigen::Vector2d across(const Eigen::Vector2d& u) { return {-u.y(), u.x()}; }

}  // namespace

Extent robust_extent(std::span<double> values) {
  if (values.empty()) {
    return {};
  }
  const auto last = static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(std::floor(kTail * last));
  const auto high = static_cast<std::size_t>(std::ceil((1.0 - kTail) * last));
  const double least = ranked(values, low);
  const double most = ranked(values, high);
  // N values spread evenly leave half an interval at either end: rank r lies at (r + 1/2) / N of
  // the length.
  const double per_rank = high > low ? (most - least) / static_cast<double>(high - low) : 0.0;
  const double cut_low = (static_cast<double>(low) + 0.5) * per_rank;
  const double cut_high = (last - static_cast<double>(high) + 0.5) * per_rank;
  return {.least = least - cut_low, .most = most + cut_high};
}

Rectangle smallest_rectangle(std::span<const Eigen::Vector2d> points) {
  Values scratch;
  Rectangle best;
  double area_best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kDirections; ++i) {
    const double angle_rad = 0.5 * std::numbers::pi * i / kDirections;
    const Eigen::Vector2d u(std::cos(angle_rad), std::sin(angle_rad));
    const Extent along = extent_along(points, u, scratch);
    const Extent beside = extent_along(points, across(u), scratch);
    const Eigen::Vector2d size(along.most - along.least, beside.most - beside.least);
    if (size.prod() < area_best) {
      area_best = size.prod();
      best.centre =
          0.5 * (along.least + along.most) * u + 0.5 * (beside.least + beside.most) * across(u);
      const bool along_is_longer = size.x() >= size.y();
      best.u = along_is_longer ? u : across(u);
      best.extents = along_is_longer ? size : Eigen::Vector2d(size.y(), size.x());
    }
  }
  return best;
}

}  // namespace polhode
