#include "shape/scale.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace polhode {
namespace {

/// An end of a length.
struct End {
  Eigen::Vector2d ray;
  SurfaceHit hit;
};

/// Variance of a length by the error of an end along its ray. Its component along the length counts
/// directly; the one across makes every length longer.
double variance_along(const End& end, const Eigen::Vector3d& direction, double length_mu) {
  const double cosine = direction.dot(end.ray.homogeneous().normalized());
  const double along = cosine * end.hit.sigma_mu;
  const double across2 = (1.0 - cosine * cosine) * end.hit.sigma_mu * end.hit.sigma_mu;
  const double longer = across2 / (2.0 * length_mu);
  return along * along + longer * longer;
}

/// Variance of a length from the error of its picked end: a shifted pixel has another ray, which
/// meets another point, at an edge even another surface. Rays without a surface are left out.
double variance_by_pick(const ScaleView& view,
                        const End& end,
                        const SurfaceHit& other,
                        double sigma_ray) {
  constexpr int kAround = 8;  // chosen: every 45 deg finds any straight edge
  // On this circle the mean square of a linear change is its variance.
  const double radius = std::numbers::sqrt2 * sigma_ray;
  const double length_mu = (end.hit.p_C - other.p_C).norm();
  double square = 0.0;
  int hits = 0;
  for (int i = 0; i < kAround && sigma_ray > 0.0; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kAround;
    const Result<SurfaceHit> hit =
        hit_surface(view, end.ray + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    if (hit) {
      const double change = (hit.value().p_C - other.p_C).norm() - length_mu;
      square += change * change;
      ++hits;
    }
  }
  const double flat = sigma_ray * end.hit.depth_mu;  // for a flat surface
  return std::max(flat * flat, hits > 0 ? square / hits : 0.0);
}

}  // namespace

Result<ScaleEstimate> scale_from_length(const ScaleView& view,
                                        const Eigen::Vector2d& end_a,
                                        const Eigen::Vector2d& end_b,
                                        double known_length_m,
                                        double sigma_ray) {
  if (!(known_length_m > 0.0) || !std::isfinite(known_length_m)) {
    return ErrorCode::kBadParameter;
  }
  const Result<SurfaceHit> a = hit_surface(view, end_a);
  const Result<SurfaceHit> b = hit_surface(view, end_b);
  if (!a || !b) {
    return a ? b.error() : a.error();
  }
  const Eigen::Vector3d apart = b.value().p_C - a.value().p_C;
  const double length_mu = apart.norm();
  if (!(length_mu > 0.0)) {
    return ErrorCode::kDegenerate;
  }
  const Eigen::Vector3d direction = apart / length_mu;
  const double by_relief = view.relief_sigma * apart.z() * apart.z() / length_mu;
  const double sigma_mu =
      std::sqrt(variance_along({.ray = end_a, .hit = a.value()}, direction, length_mu) +
                variance_along({.ray = end_b, .hit = b.value()}, direction, length_mu) +
                variance_by_pick(view, {.ray = end_a, .hit = a.value()}, b.value(), sigma_ray) +
                variance_by_pick(view, {.ray = end_b, .hit = b.value()}, a.value(), sigma_ray) +
                by_relief * by_relief);
  if (length_mu < kLengthSigmasMin * sigma_mu) {
    return ErrorCode::kDegenerate;
  }
  const double scale = known_length_m / length_mu;
  return ScaleEstimate{.metres_per_mu = scale, .sigma = scale * sigma_mu / length_mu};
}

Result<ScaleEstimate> scale_from_range(const ScaleView& view,
                                       double range_m,
                                       double sigma_range_m) {
  if (!(range_m > 0.0) || !std::isfinite(range_m) || !(sigma_range_m >= 0.0)) {
    return ErrorCode::kBadParameter;
  }
  const Result<SurfaceHit> hit = hit_surface(view, Eigen::Vector2d::Zero());
  if (!hit) {
    return hit.error();
  }
  const double scale = range_m / hit.value().depth_mu;
  const double relative =
      std::hypot(sigma_range_m / range_m, hit.value().sigma_mu / hit.value().depth_mu);
  return ScaleEstimate{.metres_per_mu = scale, .sigma = scale * relative};
}

}  // namespace polhode
