#include "shape/planes.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/consensus.hpp"
#include "shape/grouped_covariance.hpp"
#include "shape/rectangle.hpp"

namespace polhode {
namespace {

// Cosine of the largest angle between a point's normal and the plane's, 45 deg: the mean of both
// normals at an edge of 90 deg.
constexpr double kNormalCosineMin = 0.7;
// Chosen: least-squares passes until the band has settled.
constexpr int kRefinements = 6;
// Least sine of the angle at a sample's corner, 6 deg. A flatter triangle amplifies noise into
// tilt.
constexpr double kSampleSineMin = 0.1;
// Refinement narrows the band to three sigma of its inliers, but not below this part of the search
// band. Chosen: the search band may be 2.5 sigma, and this keeps most inliers of a fit too good by
// chance.
constexpr double kBandPartMin = 0.3;
constexpr double kBand_sigmas = 3.0;
// Largest ratio of points beside a plane to those on it. A slab of a thick cloud has about as many
// points beside it as on it. A surface has few: noise, and the edges of adjoining faces (decision
// 0052).
constexpr double kBesideMax = 0.8;
// Penalty for a point beside a hypothesis, in points on it. Chosen: a slab keeps half of its count.
constexpr double kBesideCost = 0.5;

struct Fit {
  Eigen::Vector3d normal_T = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d mean_T = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  std::size_t beside = 0;
  double rms = 0.0;
};

struct Support {
  std::span<const Eigen::Vector3d> points_T;
  const SurfaceNormals& normals;
  const PlaneOwners& owners;

  [[nodiscard]] bool contains(const Fit& plane, double band, std::size_t i) const {
    return owners[i] < 0 && agrees(plane, band, i);
  }
  [[nodiscard]] bool agrees(const Fit& plane, double band, std::size_t i) const {
    return std::abs(plane.normal_T.dot(points_T[i] - plane.mean_T)) <= band &&
           (!normals[i].reliable ||
            std::abs(normals[i].normal_T.dot(plane.normal_T)) >= kNormalCosineMin);
  }
  [[nodiscard]] std::size_t count(const Fit& plane, double band) const {
    std::size_t sum = 0;
    for (std::size_t i = 0; i < points_T.size(); ++i) {
      sum += contains(plane, band, i) ? 1U : 0U;
    }
    return sum;
  }
  /// Number of points off the plane by one to two bands, of any owner. A slab through the inside of
  /// a cloud has as many as within the band, and so has half of a thick surface. A surface has few.
  [[nodiscard]] std::size_t beside(const Fit& plane, double band) const {
    std::size_t sum = 0;
    for (std::size_t i = 0; i < points_T.size(); ++i) {
      const double off = std::abs(plane.normal_T.dot(points_T[i] - plane.mean_T));
      sum += off > band && agrees(plane, 2.0 * band, i) ? 1U : 0U;
    }
    return sum;
  }
};

/// Least-squares plane of the points that support `start`.
Fit refit(const Support& support, const Fit& start, double band) {
  Fit fit = start;
  fit.count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < support.points_T.size(); ++i) {
    if (support.contains(start, band, i)) {
      const Eigen::Vector3d apart = support.points_T[i] - start.mean_T;
      sum += apart;
      square += apart * apart.transpose();
      ++fit.count;
    }
  }
  if (fit.count < 3) {
    return fit;
  }
  const auto count = static_cast<double>(fit.count);
  fit.mean_T = start.mean_T + sum / count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(square -
                                                             sum * sum.transpose() / count);
  fit.normal_T = eigen.eigenvectors().col(0);
  fit.rms = std::sqrt(std::max(0.0, eigen.eigenvalues()(0)) / count);
  return fit;
}

/// Plane through three free points. Nothing where they are nearly collinear.
std::optional<Fit> plane_through(const Support& support,
                                 const CloudIndices& free,
                                 const Sample<3>& sample) {
  const Eigen::Vector3d& a = support.points_T[free[sample[0]]];
  const Eigen::Vector3d ab = support.points_T[free[sample[1]]] - a;
  const Eigen::Vector3d ac = support.points_T[free[sample[2]]] - a;
  const Eigen::Vector3d normal = ab.cross(ac);
  if (!(normal.norm() > kSampleSineMin * ab.norm() * ac.norm())) {
    return std::nullopt;
  }
  return Fit{.normal_T = normal.normalized(), .mean_T = a};
}

/// Score: the points on the plane less the penalty of those beside it, negative.
double score(const Support& support, double band, double enough, Fit* fit) {
  fit->count = support.count(*fit, band);
  const auto on = static_cast<double>(fit->count);
  if (-on >= enough) {
    return -on;  // those beside it cannot make it better
  }
  fit->beside = support.beside(*fit, band);
  return kBesideCost * static_cast<double>(fit->beside) - on;
}

/// The hypothesis with most support, refined; count is 0 when there is none.
Fit best_plane(const Support& support,
               const CloudIndices& free,
               const PlaneSearch& search,
               std::uint64_t stream,
               double* band) {
  BestHypothesis<Fit> found{.score = 0.0};  // any plane with more points than penalty
  find_consensus<3>(
      {.points = free.size(),
       .draws_max = search.iterations_max,
       .seed = search.seed,
       .stream = stream},
      [&](const Sample<3>& sample) { return plane_through(support, free, sample); },
      [&](Fit* fit, double enough) { return score(support, search.distance_max, enough, fit); },
      &found);
  Fit best = found.model;
  *band = search.distance_max;
  for (int i = 0; i < kRefinements && best.count >= 3; ++i) {
    best = refit(support, best, *band);
    *band = std::clamp(
        kBand_sigmas * best.rms, kBandPartMin * search.distance_max, search.distance_max);
  }
  best.beside = support.beside(best, search.distance_max);
  if (static_cast<double>(best.beside) > kBesideMax * static_cast<double>(best.count)) {
    best.count = 0;
  }
  return best;
}

/// Covariance of the tilts about the long and the short edge and of the offset at the inliers'
/// mean, from the scatter of the rectangle's parts. Not less than by white noise.
Eigen::Matrix3d covariance_of(const Fit& fit,
                              const Plane& plane,
                              const PlaneOwners& owners,
                              std::int8_t number,
                              const Support& support) {
  // 4 by 4 parts (decision 0054). Five filled ones are needed for three unknowns.
  constexpr std::size_t kParts = 4;
  const auto part = [](double along, double extent) {
    const double place = std::clamp(along / extent + 0.5, 0.0, 1.0);
    return std::min(kParts - 1, static_cast<std::size_t>(place * kParts));
  };
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  GroupedCovariance<3, kParts * kParts> grouped;
  if (!(plane.extents.minCoeff() > 0.0)) {
    return Eigen::Matrix3d::Zero();
  }
  for (std::size_t i = 0; i < owners.size(); ++i) {
    if (owners[i] != number) {
      continue;
    }
    const Eigen::Vector2d from_mean = plane.axes_T.transpose() * (support.points_T[i] - fit.mean_T);
    const Eigen::Vector2d from_centre =
        plane.axes_T.transpose() * (support.points_T[i] - plane.centre_T);
    // A tilt by a about u takes a v off the distance, one by b about v adds b u.
    const Eigen::Vector3d J(-from_mean.y(), from_mean.x(), -1.0);
    information += J * J.transpose();
    grouped.add(part(from_centre.x(), plane.extents.x()) * kParts +
                    part(from_centre.y(), plane.extents.y()),
                plane.distance(support.points_T[i]) * J);
  }
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(information);
  if (!(ldlt.vectorD().minCoeff() > 0.0)) {
    return Eigen::Matrix3d::Zero();
  }
  const Eigen::Matrix3d white = fit.rms * fit.rms * ldlt.solve(Eigen::Matrix3d::Identity());
  return not_below(white, grouped.covariance(information));
}

Plane describe(const Fit& fit,
               const PlaneOwners& owners,
               std::int8_t number,
               const Support& support,
               const Eigen::Vector3d& centroid) {
  Plane plane;
  plane.normal_T =
      fit.normal_T.dot(fit.mean_T - centroid) < 0.0 ? Eigen::Vector3d(-fit.normal_T) : fit.normal_T;
  plane.offset = plane.normal_T.dot(fit.mean_T);
  plane.rms = fit.rms;
  FixedVector<Eigen::Vector2d, limits::kCloudPoints> flat;
  const Eigen::Vector3d e1 = plane.normal_T.unitOrthogonal();
  const Eigen::Vector3d e2 = plane.normal_T.cross(e1);
  for (std::size_t i = 0; i < owners.size(); ++i) {
    if (owners[i] == number) {
      const Eigen::Vector3d apart = support.points_T[i] - fit.mean_T;
      POLHODE_ASSERT(flat.push_back({e1.dot(apart), e2.dot(apart)}), i);
    }
  }
  plane.inliers = flat.size();
  const Rectangle rectangle = smallest_rectangle(flat.view());
  plane.centre_T = fit.mean_T + e1 * rectangle.centre.x() + e2 * rectangle.centre.y();
  plane.axes_T.col(0) = e1 * rectangle.u.x() + e2 * rectangle.u.y();
  plane.axes_T.col(1) = plane.normal_T.cross(plane.axes_T.col(0));
  plane.extents = rectangle.extents;
  plane.beside = fit.beside;
  plane.covariance = covariance_of(fit, plane, owners, number, support);
  return plane;
}

}  // namespace

void find_planes(std::span<const Eigen::Vector3d> points_T,
                 const SurfaceNormals& normals,
                 const PlaneSearch& search,
                 PlaneOwners& owners,
                 Planes& planes) {
  POLHODE_ASSERT(normals.size() == points_T.size() && owners.size() == points_T.size(),
                 points_T.size());
  planes.clear();
  if (points_T.empty()) {
    return;
  }
  const Support support{.points_T = points_T, .normals = normals, .owners = owners};
  const Eigen::Vector3d centroid = centroid_T(points_T);
  while (!planes.full()) {
    CloudIndices free;
    for (std::size_t i = 0; i < points_T.size(); ++i) {
      if (owners[i] < 0) {
        POLHODE_ASSERT(free.push_back(static_cast<std::uint16_t>(i)), i);
      }
    }
    if (free.size() < std::max<std::size_t>(3, search.inliers_min)) {
      return;
    }
    double band = 0.0;
    const Fit fit = best_plane(support, free, search, planes.size(), &band);
    if (fit.count < search.inliers_min) {
      return;
    }
    const auto number = static_cast<std::int8_t>(planes.size());
    for (std::size_t i = 0; i < points_T.size(); ++i) {
      if (support.contains(fit, band, i)) {
        owners[i] = number;
      }
    }
    POLHODE_ASSERT(planes.push_back(describe(fit, owners, number, support, centroid)),
                   planes.size());
  }
}

}  // namespace polhode
