// Flat faces of the target: RANSAC with a fixed seed, refined by least squares, with their extents.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "shape/normals.hpp"

namespace polhode {

/// Points p of the plane: normal_T . p = offset. The rectangle contains its points; lengths in
/// units of the cloud.
struct Plane {
  Eigen::Vector3d normal_T = Eigen::Vector3d::UnitZ();  ///< unit, away from the cloud's centroid
  double offset = 0.0;
  Eigen::Vector3d centre_T = Eigen::Vector3d::Zero();  ///< of the rectangle
  Eigen::Matrix<double, 3, 2> axes_T =
      Eigen::Matrix<double, 3, 2>::Zero();            ///< unit: long edge u, short edge v
  Eigen::Vector2d extents = Eigen::Vector2d::Zero();  ///< full lengths along u and v
  std::size_t inliers = 0;
  std::size_t beside = 0;  ///< points off it by one to two bands: few for a real surface
  double rms = 0.0;        ///< of the inliers' distances
  /// Of (tilt about u [rad], tilt about v [rad], offset at the inliers' mean), from the residuals
  /// of the rectangle's parts.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  [[nodiscard]] double distance(const Eigen::Vector3d& point_T) const {
    return normal_T.dot(point_T) - offset;
  }
};

using Planes = FixedVector<Plane, limits::kPlanes>;
/// Index of the plane that a point belongs to; -1: none.
using PlaneOwners = FixedVector<std::int8_t, limits::kCloudPoints>;

struct PlaneSearch {
  double distance_max = 0.0;     ///< of an inlier from its plane, cloud's unit
  std::size_t inliers_min = 10;  ///< of direct callers; a Shape requires a part of its points
  int iterations_max = 500;      ///< hypotheses for each plane; ShapeOptions::plane_iterations_max
  std::uint64_t seed = 1;
};

/// Finds planes one by one, the one with most points first, until none has inliers_min or the table
/// is full. A point supports a plane when it is near and its normal, where reliable, agrees within
/// 45 deg: normals near a cut across the body do not. A plane with many points beside it is such a
/// cut, and ends the search.
/// @param owners  points with a value other than -1 on entry take no part; on return each point's
/// plane.
/// @cost  iterations_max times the points, for each plane.
void find_planes(std::span<const Eigen::Vector3d> points_T,
                 const SurfaceNormals& normals,
                 const PlaneSearch& search,
                 PlaneOwners& owners,
                 Planes& planes);

}  // namespace polhode
