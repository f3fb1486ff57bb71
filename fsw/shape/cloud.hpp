// The target's points: outlier removal, homogenisation, centroid. Every length is measured in the
// cloud's own spacing.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "base/result.hpp"
#include "config/limits.hpp"
#include "shape/options.hpp"

namespace polhode {

/// Points in T; the first ones are measured, those from `measured` on were added by completion.
struct Cloud {
  FixedVector<Eigen::Vector3d, limits::kCloudPoints> points_T;
  std::size_t measured = 0;
};

using CloudIndices = FixedVector<std::uint16_t, limits::kCloudPoints>;
static_assert(limits::kCloudPoints <= 65535);

/// Working space, owned by the caller; holds nothing between calls.
struct CloudScratch {
  CloudIndices by_x;  ///< points in the order of their x: neighbours are found within a slab
  FixedVector<Eigen::Vector3d, limits::kCloudPoints> points_T;
};

/// Fills `scratch.by_x`.
void sort_by_x(std::span<const Eigen::Vector3d> points_T, CloudScratch& scratch);

/// Calls visit(index of another point, squared distance) for all points within `radius` of the
/// point at place `at` of `by_x`, and some beyond it.
template <typename Visit>
void visit_neighbours(std::span<const Eigen::Vector3d> points_T,
                      const CloudIndices& by_x,
                      std::size_t at,
                      double radius,
                      const Visit& visit) {
  const Eigen::Vector3d& centre_T = points_T[by_x[at]];
  for (std::size_t i = at; i-- > 0 && centre_T.x() - points_T[by_x[i]].x() <= radius;) {
    visit(by_x[i], (points_T[by_x[i]] - centre_T).squaredNorm());
  }
  for (std::size_t i = at + 1; i < by_x.size() && points_T[by_x[i]].x() - centre_T.x() <= radius;
       ++i) {
    visit(by_x[i], (points_T[by_x[i]] - centre_T).squaredNorm());
  }
}

/// Typical distance of a point to its nearest neighbour on the surface: the median distance to the
/// fourth nearest, over 2.19 (their ratio for points spread at random on a surface). The fourth,
/// because features come in clumps.
/// @errors TooFewObservations (under 5 points), Degenerate (more than half of the points coincide
/// with 4 others).
/// @cost   O(N) slabs of the width of four spacings.
Result<double> median_spacing(std::span<const Eigen::Vector3d> points_T, CloudScratch& scratch);

/// Keeps the points that have at least `neighbours_min` others within `radius`; order kept.
/// @return number removed.
std::size_t remove_outliers(double radius, int neighbours_min, CloudScratch& scratch, Cloud& cloud);

/// One point, the mean, for each occupied cube of edge `edge`; ordered by cube.
/// @return number of points gone.
std::size_t homogenise(double edge, CloudScratch& scratch, Cloud& cloud);

/// Mean of all points. The cloud must not be empty.
Eigen::Vector3d centroid_T(std::span<const Eigen::Vector3d> points_T);

/// Landmarks to cloud: outliers removed, homogenised. Landmarks beyond the table's capacity are
/// left out, last first.
/// @return the spacing of the landmarks. Points that are not finite are left out.
/// @errors TooFewObservations, Degenerate (see median_spacing(), or nothing is left).
Result<double> denoise(std::span<const Eigen::Vector3d> landmarks_T,
                       const ShapeOptions& options,
                       CloudScratch& scratch,
                       Cloud& cloud);

}  // namespace polhode
