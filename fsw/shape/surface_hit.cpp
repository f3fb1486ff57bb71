#include "shape/surface_hit.hpp"

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

// Nearest landmarks among which a plane is searched for. Chosen for its cost: all 2024 triples are
// tried, three times.
constexpr std::size_t kNearest = 24;
// Largest distance of the nearest landmark from the ray, in typical distances; beyond it the ray
// misses the target. Chosen; smaller refuses bare parts of a surface, larger takes rays beside the
// body.
constexpr double kMissDistances = 6.0;
// Band of a plane along the ray, in typical distances: three sigma of a cloud whose noise is a
// third of its spacing.
constexpr double kBandDistances = 1.0;
// Least part of the band after refinement: a few landmarks may agree by chance. Chosen.
constexpr double kHitBandPartMin = 0.1;
constexpr double kHitBand_sigmas = 3.0;
// At an edge two faces share the landmarks around the ray. The nearer face is taken when it has
// this part of the other's support. Chosen; smaller takes a few stray points in front for a face,
// larger misses the nearer face.
constexpr double kFrontPart = 0.5;
// Least cosine of a face's obliquity, 78 deg: a more oblique one shows next to no landmarks. A
// plane of such a tilt joins points of two faces.
constexpr double kFacingCosineMin = 0.2;
// Nearest landmarks of which two must be on the plane. A large face with only farther landmarks
// would be extrapolated over a panel behind or beside the body.
constexpr std::size_t kWitnesses = 4;
constexpr std::size_t kWitnessesMin = 2;
// Least landmarks of a plane: three determine it, two more check it.
constexpr std::size_t kPlaneSupportMin = 5;
// Chosen: least-squares passes until the set of inliers has settled.
constexpr int kHitRefinements = 5;
// Least triangle of a triple, in parts of the neighbourhood's radius squared. Smaller ones
// extrapolate noise. Chosen.
constexpr double kTriangleMin = 0.01;
// Landmarks whose scatter in depth gives the sigma where no plane is found: a triangle's three
// corners.
constexpr std::size_t kNearestDepths = 3;

// Errors of landmarks over the sigmas that their observations give: measured on rendered scenes,
// see decision 0074.
constexpr double kOwnSigmas = 2.0;

struct Seen {
  Eigen::Vector2d offset = Eigen::Vector2d::Zero();  // in the image, from the ray
  double distance2 = 0.0;
  double depth = 0.0;
  double sigma = 0.0;   // along its ray
  double weight = 1.0;  // in the fit of the surface at the ray
};

using SeenTable = FixedVector<Seen, limits::kLandmarks>;

bool nearer(const Seen& a, const Seen& b) { return a.distance2 < b.distance2; }

void collect(const ScaleView& view, const Eigen::Vector2d& ray, SeenTable& seen) {
  for (std::size_t i = 0; i < view.landmarks_T.size() && !seen.full(); ++i) {
    const Eigen::Vector3d p_C = view.pose.to_camera(view.landmarks_T[i]);
    if (p_C.allFinite() && p_C.z() > 0.0) {
      const Eigen::Vector2d offset = p_C.hnormalized() - ray;
      (void)seen.push_back({.offset = offset,
                            .distance2 = offset.squaredNorm(),
                            .depth = p_C.z(),
                            .sigma = i < view.sigmas_mu.size() ? view.sigmas_mu[i] : 0.0});
    }
  }
}

/// Typical distance in the image between landmarks spread evenly over their bounding box.
double typical_distance(const SeenTable& seen) {
  Eigen::Vector2d least = seen[0].offset;
  Eigen::Vector2d most = seen[0].offset;
  for (const Seen& one : seen) {
    least = least.cwiseMin(one.offset);
    most = most.cwiseMax(one.offset);
  }
  return (most - least).norm() / std::sqrt(static_cast<double>(seen.size()));
}

using NearTable = FixedVector<Seen, kNearest>;

/// The landmarks nearest to the ray in the image.
void take_near(SeenTable& seen, double reach2, NearTable& near) {
  const std::size_t around = std::min<std::size_t>(seen.size(), kNearest);
  std::partial_sort(seen.begin(), seen.begin() + around, seen.end(), nearer);
  for (std::size_t i = 0; i < around && seen[i].distance2 <= reach2; ++i) {
    POLHODE_ASSERT(near.push_back(seen[i]), i);
  }
  // Weights by distance: a quarter at the last witness. Landmarks far from the ray are many, and
  // more often on another face.
  const double close2 = near.empty() ? 0.0 : near[std::min(kWitnesses, near.size()) - 1].distance2;
  for (Seen& one : near) {
    const double ratio = close2 > 0.0 ? one.distance2 / close2 : 0.0;
    one.weight = 1.0 / ((1.0 + ratio) * (1.0 + ratio));
  }
}

/// Inverse depth over the image: a + b . offset. A plane in space is linear there.
struct InversePlane {
  Eigen::Vector3d coefficients = Eigen::Vector3d::Zero();
  std::size_t support = 0;

  [[nodiscard]] double at(const Seen& seen) const {
    return coefficients(0) + coefficients.tail<2>().dot(seen.offset);
  }
  /// Cosine of the angle between the plane's normal and the ray.
  [[nodiscard]] double facing(const Eigen::Vector2d& ray) const {
    const Eigen::Vector2d slope = coefficients.tail<2>();
    const Eigen::Vector3d normal_C(slope.x(), slope.y(), coefficients(0) - slope.dot(ray));
    return coefficients(0) / (normal_C.norm() * ray.homogeneous().norm());
  }
  [[nodiscard]] bool contains(const Seen& seen, double band) const {
    const double inverse = at(seen);
    return inverse > 0.0 && std::abs(1.0 / inverse - seen.depth) <= band;
  }
};

std::size_t support_of(const InversePlane& plane, const NearTable& near, double band) {
  std::size_t count = 0;
  for (const Seen& seen : near) {
    count += plane.contains(seen, band) ? 1U : 0U;
  }
  return count;
}

bool through(const Seen& a, const Seen& b, const Seen& c, double spread2, InversePlane* plane) {
  Eigen::Matrix2d A;
  A.row(0) = (b.offset - a.offset).transpose();
  A.row(1) = (c.offset - a.offset).transpose();
  if (!(std::abs(A.determinant()) > kTriangleMin * spread2)) {
    return false;
  }
  const Eigen::Vector2d slope =
      A.inverse() * Eigen::Vector2d(1.0 / b.depth - 1.0 / a.depth, 1.0 / c.depth - 1.0 / a.depth);
  plane->coefficients << 1.0 / a.depth - slope.dot(a.offset), slope;
  return true;
}

bool witnessed(const InversePlane& plane, const NearTable& near, double band) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < std::min(kWitnesses, near.size()); ++i) {
    count += plane.contains(near[i], band) ? 1U : 0U;
  }
  return count >= kWitnessesMin;
}

/// Calls visit(plane) for the planes through all triples that meet the ray no nearer than the
/// nearest landmark, face the camera and have landmarks next to the ray.
template <typename Visit>
void for_planes(const NearTable& near,
                const Eigen::Vector2d& ray,
                double band,
                const Visit& visit) {
  double front = near[0].depth;
  double spread2 = 0.0;
  for (const Seen& seen : near) {
    front = std::min(front, seen.depth);
    spread2 = std::max(spread2, (seen.offset - near[0].offset).squaredNorm());
  }
  for (std::size_t i = 0; i < near.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      for (std::size_t k = 0; k < j; ++k) {
        InversePlane plane;
        if (through(near[i], near[j], near[k], spread2, &plane) && plane.coefficients(0) > 0.0 &&
            1.0 / plane.coefficients(0) > front - band && plane.facing(ray) >= kFacingCosineMin &&
            witnessed(plane, near, band)) {
          plane.support = support_of(plane, near, band);
          visit(plane);
        }
      }
    }
  }
}

/// The nearest plane on the ray that enough landmarks support.
InversePlane front_plane(const NearTable& near, const Eigen::Vector2d& ray, double band) {
  std::size_t most = 0;
  for_planes(near, ray, band, [&most](const InversePlane& plane) {
    most = std::max(most, plane.support);
  });
  const auto enough =
      std::max(kPlaneSupportMin,
               static_cast<std::size_t>(std::ceil(kFrontPart * static_cast<double>(most))));
  double depth_least = 0.0;
  for_planes(near, ray, band, [&](const InversePlane& plane) {
    const double depth = 1.0 / plane.coefficients(0);
    depth_least = plane.support >= enough && (depth_least == 0.0 || depth < depth_least)
                      ? depth
                      : depth_least;
  });
  // Takes the best supported plane within two bands of the nearest, one for the noise of each. The
  // nearest by itself may be so by noise.
  InversePlane best;
  for_planes(near, ray, band, [&](const InversePlane& plane) {
    if (plane.support >= enough && 1.0 / plane.coefficients(0) <= depth_least + 2.0 * band &&
        plane.support > best.support) {
      best = plane;
    }
  });
  return best;
}

struct InverseDepth {
  double value = 0.0;
  double sigma = 0.0;
};

/// The plane taken, and its band.
struct Surface {
  InversePlane plane;
  double band = 0.0;
};

/// Least squares over the plane's landmarks, selected again after each step within three sigma. So
/// landmarks of another face next to an edge drop out. Gives inverse depth and its sigma at the
/// ray.
bool refine(const NearTable& near, Surface* surface, InverseDepth* at_ray) {
  const double band_max = surface->band;
  InversePlane& plane = surface->plane;
  double& band = surface->band;
  for (int pass = 0; pass < kHitRefinements; ++pass) {
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d H2 = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    double square = 0.0;
    std::size_t count = 0;
    for (const Seen& seen : near) {
      if (plane.contains(seen, band)) {
        const Eigen::Vector3d J(1.0, seen.offset.x(), seen.offset.y());
        const double residual = 1.0 / seen.depth - plane.at(seen);
        H += seen.weight * J * J.transpose();
        H2 += seen.weight * seen.weight * J * J.transpose();
        g += seen.weight * J * residual;
        square += residual * residual;
        ++count;
      }
    }
    const Eigen::LDLT<Eigen::Matrix3d> ldlt(H);
    if (count < kPlaneSupportMin || !(ldlt.vectorD().minCoeff() > 0.0)) {
      return false;
    }
    plane.coefficients += ldlt.solve(g);
    const double variance = square / static_cast<double>(count - 3);
    band = std::clamp(kHitBand_sigmas * near[0].depth * near[0].depth * std::sqrt(variance),
                      kHitBandPartMin * band_max,
                      band_max);
    at_ray->value = plane.coefficients(0);
    const Eigen::Vector3d at_zero = ldlt.solve(Eigen::Vector3d::UnitX());
    at_ray->sigma = std::sqrt(variance * at_zero.dot(H2 * at_zero));
  }
  return at_ray->value > 0.0 && std::isfinite(at_ray->sigma);
}

/// Without a plane: the nearest landmark's depth, with the scatter of those around it as sigma.
InverseDepth nearest_depth(const NearTable& near) {
  double deviation = near[0].depth * std::sqrt(near[0].distance2);
  for (std::size_t i = 1; i < std::min(kNearestDepths, near.size()); ++i) {
    deviation = std::max(deviation, std::abs(near[i].depth - near[0].depth));
  }
  return {.value = 1.0 / near[0].depth, .sigma = deviation / (near[0].depth * near[0].depth)};
}

/// Variance of the depth by landmarks about the ray on other surfaces: the ray may meet one of
/// those, with the probability of their share of the weight.
double variance_by_others(const NearTable& near, const Surface& surface) {
  double weight = 0.0;
  double square = 0.0;
  for (const Seen& seen : near) {
    weight += seen.weight;
    if (!surface.plane.contains(seen, surface.band)) {
      const double inverse = surface.plane.at(seen);
      // Beyond the plane's horizon: off by the landmark's depth.
      const double off = inverse > 0.0 ? 1.0 / inverse - seen.depth : seen.depth;
      square += seen.weight * std::min(off * off, seen.depth * seen.depth);
    }
  }
  return square / weight;
}

/// Variance of the depth by the errors of the landmarks about the ray, which are correlated.
double own_variance(const NearTable& near) {
  double weight = 0.0;
  double sigma = 0.0;
  for (const Seen& seen : near) {
    weight += seen.weight;
    sigma += seen.weight * seen.sigma;
  }
  sigma *= kOwnSigmas / weight;
  return sigma * sigma;
}

}  // namespace

Result<SurfaceHit> hit_surface(const ScaleView& view, const Eigen::Vector2d& ray) {
  SeenTable seen;
  collect(view, ray, seen);
  if (seen.size() < 3) {
    return ErrorCode::kTooFewObservations;
  }
  const double typical = typical_distance(seen);
  const double reach = kMissDistances * typical;
  NearTable near;
  take_near(seen, reach * reach, near);
  if (near.empty() || !(reach > 0.0)) {
    return ErrorCode::kDegenerate;
  }
  const double band = kBandDistances * typical * near[0].depth;
  Surface surface{.plane = front_plane(near, ray, band), .band = band};
  InverseDepth at_ray;
  double variance = own_variance(near);
  if (surface.plane.support >= kPlaneSupportMin && refine(near, &surface, &at_ray)) {
    variance += variance_by_others(near, surface);
  } else {
    at_ray = nearest_depth(near);
  }
  SurfaceHit hit;
  hit.depth_mu = 1.0 / at_ray.value;
  const double sigma = hit.depth_mu * hit.depth_mu * at_ray.sigma;
  hit.sigma_mu = ray.homogeneous().norm() * std::sqrt(sigma * sigma + variance);
  hit.p_C = hit.depth_mu * ray.homogeneous();
  return hit;
}

}  // namespace polhode
