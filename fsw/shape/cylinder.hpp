// A round body: tanks and upper stages.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/result.hpp"
#include "shape/normals.hpp"

namespace polhode {

struct Cylinder {
  Eigen::Vector3d axis_T = Eigen::Vector3d::UnitZ();   ///< unit, either sign
  Eigen::Vector3d centre_T = Eigen::Vector3d::Zero();  ///< on the axis, at half length
  double radius = 0.0;
  double length = 0.0;        ///< of the part that has points
  double coverage_rad = 0.0;  ///< angle of the sectors that have points, at most 2 pi
  int ends_found = 0;         ///< flat ends found across the axis, 0 .. 2
  std::size_t inliers = 0;
  std::size_t beside = 0;       ///< points off the surface by one to two bands
  double rms = 0.0;             ///< of the inliers' distances
  double sigma_axis_rad = 0.0;  ///< 1-sigma, worst direction, from the residuals of its parts
  double sigma_radius = 0.0;    ///< 1-sigma, likewise; in a Shape with the bend of the map

  /// Distance from the round surface, positive outside.
  [[nodiscard]] double distance(const Eigen::Vector3d& point_T) const {
    return axis_T.cross(point_T - centre_T).norm() - radius;
  }
};

struct CylinderSearch {
  double distance_max = 0.0;     ///< of an inlier from the surface, cloud's unit
  std::size_t inliers_min = 20;  ///< of direct callers; a Shape requires a third of its points
  int iterations_max = 500;      ///< ShapeOptions::plane_iterations_max
  std::uint64_t seed = 1;
};

/// Finds the round surface with most inliers: points near it whose normal, where reliable, is
/// radial within 30 deg. A hypothesis takes its axis from two normals or from the whole cloud, its
/// circle from three points. It is refined by robust least squares on the distances.
/// @errors TooFewObservations (fewer points than inliers_min), NoConsensus (too few inliers, or
/// points over less than 90 deg of the circle, which a plane explains as well).
Result<Cylinder> find_cylinder(std::span<const Eigen::Vector3d> points_T,
                               const SurfaceNormals& normals,
                               const CylinderSearch& search);

}  // namespace polhode
