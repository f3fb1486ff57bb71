// The target's points: outlier removal, homogenisation, centroid. Lengths are in spacings of the
// cloud, so the unit of the map does not matter.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "base/result.hpp"
#include "config/limits.hpp"
#include "shape/options.hpp"
#include "solve/point_tree.hpp"

namespace polhode {

/// Points in T; the first ones are measured, those from `measured` on were added by completion.
struct Cloud {
  FixedVector<Eigen::Vector3d, limits::kCloudPoints> points_T;
  std::size_t measured = 0;
};

using CloudIndices = PointIndices;

/// Workspace, owned by the caller. Holds nothing between calls.
struct CloudScratch {
  CloudIndices indices;  ///< result of a search; an order of all points
  FixedVector<Eigen::Vector3d, limits::kCloudPoints> points_T;
};

/// Typical distance of a point to its nearest neighbour on the surface. It is the median distance
/// to the fourth nearest, over the ratio of both for random points on a surface. Such points have a
/// density of 1 / (2 spacings)^2.
/// @errors TooFewObservations (under 5 points), Degenerate (more than half of the points coincide
/// with 4 others).
/// @cost   O(N log N).
Result<double> median_spacing(std::span<const Eigen::Vector3d> points_T);

/// Keeps the points that have at least `neighbours_min` others within `radius`; order kept.
/// @return number removed.
std::size_t remove_outliers(double radius, int neighbours_min, CloudScratch& scratch, Cloud& cloud);

/// Numbers of the cube of edge `edge` that contains a point, as homogenise() divides space.
std::array<std::int64_t, 3> cube_of(const Eigen::Vector3d& point_T, double edge);

/// Replaces the points of each occupied cube of edge `edge` by their mean; ordered by cube.
/// @return number of points removed.
std::size_t homogenise(double edge, CloudScratch& scratch, Cloud& cloud);

/// Mean of all points. The cloud must not be empty.
Eigen::Vector3d centroid_T(std::span<const Eigen::Vector3d> points_T);

/// Landmarks to cloud: outliers removed, homogenised. Non-finite landmarks are left out, and the
/// last ones where the table is full.
/// @return the spacing of the landmarks.
/// @errors TooFewObservations, Degenerate (see median_spacing(), or nothing is left).
Result<double> denoise(std::span<const Eigen::Vector3d> landmarks_T,
                       const ShapeOptions& options,
                       CloudScratch& scratch,
                       Cloud& cloud);

}  // namespace polhode
