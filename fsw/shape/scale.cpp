#include "shape/scale.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"

namespace polhode {
namespace {

constexpr std::size_t kNearest = 12;
// A ray whose nearest landmark is farther than this many typical distances misses the target.
constexpr double kMissDistances = 6.0;
// Landmarks this much deeper than the nearest surface, in parts of the target's depth, belong to a farther one.
constexpr double kFarSidePart = 0.3;
constexpr int kRobustPasses = 8;
constexpr double kTukey = 4.685;  // 95 % efficiency on normal noise
constexpr double kSigmasMin = 5.0;

struct Seen {
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  // in the picture, from the ray
  double distance2 = 0.0;
  double depth = 0.0;
};

using SeenTable = FixedVector<Seen, limits::kLandmarks>;

bool nearer(const Seen& a, const Seen& b) { return a.distance2 < b.distance2; }

void collect(const ScaleView& view, const Eigen::Vector2d& ray, SeenTable& seen) {
  for (const Eigen::Vector3d& landmark_T : view.landmarks_T) {
    const Eigen::Vector3d p_C = view.pose.to_camera(landmark_T);
    if (p_C.allFinite() && p_C.z() > 0.0) {
      const Eigen::Vector2d offset = p_C.hnormalized() - ray;
      if (!seen.push_back({.offset = offset, .distance2 = offset.squaredNorm(), .depth = p_C.z()})) {
        return;
      }
    }
  }
}

/// Distance in the picture that landmarks spread evenly over their bounding box would have from their nearest neighbours.
double typical_distance(const SeenTable& seen) {
  Eigen::Vector2d least = seen[0].offset;
  Eigen::Vector2d most = seen[0].offset;
  for (const Seen& one : seen) {
    least = least.cwiseMin(one.offset);
    most = most.cwiseMax(one.offset);
  }
  return (most - least).norm() / std::sqrt(static_cast<double>(seen.size()));
}

/// The landmarks near the ray that belong to the nearest surface there: by distance in the picture, at most kNearest.
using NearTable = FixedVector<Seen, kNearest>;
void take_near_surface(SeenTable& seen, double reach2, NearTable& near) {
  double least_depth = seen[0].depth;
  double most_depth = seen[0].depth;
  for (const Seen& one : seen) {
    least_depth = std::min(least_depth, one.depth);
    most_depth = std::max(most_depth, one.depth);
  }
  // The front of what is around the ray, then all that is not much deeper.
  const std::size_t around = std::min<std::size_t>(seen.size(), 2 * kNearest);
  std::partial_sort(seen.begin(), seen.begin() + around, seen.end(), nearer);
  double front = most_depth;
  for (std::size_t i = 0; i < around && seen[i].distance2 <= reach2; ++i) {
    front = std::min(front, seen[i].depth);
  }
  const double limit = front + kFarSidePart * (most_depth - least_depth);
  for (std::size_t i = 0; i < around && seen[i].distance2 <= reach2 && !near.full(); ++i) {
    if (seen[i].depth <= limit) {
      POLHODE_ASSERT(near.push_back(seen[i]), i);
    }
  }
}

struct InverseDepth {
  double value = 0.0;
  double sigma = 0.0;
};

double median_of_magnitudes(const std::array<double, kNearest>& residuals, std::size_t count) {
  std::array<double, kNearest> sorted{};
  for (std::size_t i = 0; i < count; ++i) {
    sorted[i] = std::abs(residuals[i]);
  }
  std::sort(sorted.begin(), sorted.begin() + count);
  return sorted[count / 2];
}

/// Robust fit of inverse depth = a + b . offset (or a alone); the value at the ray is a. False when singular.
bool fit_inverse_depth(const NearTable& near, int unknowns, double reach, InverseDepth* at_ray) {
  std::array<double, kNearest> weights{};
  weights.fill(1.0);
  std::array<double, kNearest> residuals{};
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double scale = 0.0;
  for (int pass = 0; pass < kRobustPasses; ++pass) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < near.size(); ++i) {
      const Eigen::Vector3d J(1.0, near[i].offset.x() / reach, near[i].offset.y() / reach);
      H += weights[i] * J * J.transpose();
      g += weights[i] * J / near[i].depth;
    }
    if (unknowns == 1) {
      H.block<2, 2>(1, 1) = Eigen::Matrix2d::Identity();
      H(0, 1) = H(1, 0) = H(0, 2) = H(2, 0) = 0.0;
      g.tail<2>().setZero();
    }
    const Eigen::LDLT<Eigen::Matrix3d> ldlt(H);
    // 1e-4: offsets spread over less than a hundredth of the reach in one direction lie on a line.
    if (!(ldlt.vectorD().minCoeff() > 1e-4)) {
      return false;
    }
    x = ldlt.solve(g);
    covariance = ldlt.solve(Eigen::Matrix3d::Identity());
    for (std::size_t i = 0; i < near.size(); ++i) {
      residuals[i] = 1.0 / near[i].depth - x(0) - x.tail<2>().dot(near[i].offset) / reach;
    }
    scale = 1.4826 * median_of_magnitudes(residuals, near.size());
    for (std::size_t i = 0; i < near.size(); ++i) {
      const double u = scale > 0.0 ? residuals[i] / (kTukey * scale) : 0.0;
      weights[i] = std::abs(u) < 1.0 ? (1.0 - u * u) * (1.0 - u * u) : 0.0;
    }
  }
  // The median of few residuals is small by n / (n - unknowns); exact data have no scale, and then no doubt either.
  const auto count = static_cast<double>(near.size());
  const double variance = scale * scale * count / std::max(1.0, count - unknowns);
  *at_ray = {.value = x(0), .sigma = std::sqrt(variance * covariance(0, 0))};
  return x.allFinite() && x(0) > 0.0;
}

}  // namespace

Result<SurfaceHit> hit_surface(const ScaleView& view, const Eigen::Vector2d& ray) {
  SeenTable seen;
  collect(view, ray, seen);
  if (seen.size() < 3) {
    return ErrorCode::kTooFewObservations;
  }
  const double reach = kMissDistances * typical_distance(seen);
  NearTable near;
  take_near_surface(seen, reach * reach, near);
  if (near.empty() || !(reach > 0.0)) {
    return ErrorCode::kDegenerate;
  }
  InverseDepth at_ray;
  // Five points leave two to judge the plane by.
  const bool flat = near.size() >= 5 && fit_inverse_depth(near, 3, reach, &at_ray);
  if (!flat && !fit_inverse_depth(near, 1, reach, &at_ray)) {
    return ErrorCode::kDegenerate;
  }
  SurfaceHit hit;
  hit.depth_mu = 1.0 / at_ray.value;
  const double along = ray.homogeneous().norm();
  hit.sigma_mu = along * hit.depth_mu * hit.depth_mu * at_ray.sigma;
  if (!flat && near.size() < 3) {
    // One or two landmarks say nothing of the slope: the depth may change as much as their distance from the ray.
    hit.sigma_mu = std::max(hit.sigma_mu, hit.depth_mu * std::sqrt(near[0].distance2));
  }
  hit.p_C = hit.depth_mu * ray.homogeneous();
  return hit;
}

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
  // Errors along the two rays count by their part along the length; a picked point moves its end across the ray.
  const Eigen::Vector3d direction = apart / length_mu;
  const double by_a = direction.dot(end_a.homogeneous().normalized()) * a.value().sigma_mu;
  const double by_b = direction.dot(end_b.homogeneous().normalized()) * b.value().sigma_mu;
  const double by_pick = sigma_ray * std::hypot(a.value().depth_mu, b.value().depth_mu);
  const double sigma_mu = std::sqrt(by_a * by_a + by_b * by_b + by_pick * by_pick);
  if (length_mu < kSigmasMin * sigma_mu) {
    return ErrorCode::kDegenerate;
  }
  const double scale = known_length_m / length_mu;
  return ScaleEstimate{.metres_per_mu = scale, .sigma = scale * sigma_mu / length_mu};
}

Result<ScaleEstimate> scale_from_range(const ScaleView& view, double range_m, double sigma_range_m) {
  if (!(range_m > 0.0) || !std::isfinite(range_m) || !(sigma_range_m >= 0.0)) {
    return ErrorCode::kBadParameter;
  }
  const Result<SurfaceHit> hit = hit_surface(view, Eigen::Vector2d::Zero());
  if (!hit) {
    return hit.error();
  }
  const double scale = range_m / hit.value().depth_mu;
  const double relative = std::hypot(sigma_range_m / range_m, hit.value().sigma_mu / hit.value().depth_mu);
  return ScaleEstimate{.metres_per_mu = scale, .sigma = scale * relative};
}

}  // namespace polhode
