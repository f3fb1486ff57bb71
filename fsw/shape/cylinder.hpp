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
  double length = 0.0;  ///< of the part that has points
  double coverage_rad =
      0.0;             ///< how much of the round has points, in sectors of 10 deg; at most 2 pi
  int ends_found = 0;  ///< flat ends found across the axis, 0 .. 2
  std::size_t inliers = 0;
  std::size_t beside = 0;       ///< points just off the round surface, as far out again
  double rms = 0.0;             ///< of the inliers' distances
  double sigma_axis_rad = 0.0;  ///< 1-sigma, worst direction, from the residuals of its parts
  double sigma_radius = 0.0;    ///< 1-sigma, likewise; in a Shape with what a map bends surfaces by

  /// Distance from the round surface, positive outside.
  [[nodiscard]] double distance(const Eigen::Vector3d& point_T) const {
    return axis_T.cross(point_T - centre_T).norm() - radius;
  }
};

struct CylinderSearch {
  double distance_max = 0.0;  ///< of an inlier from the surface, cloud's unit
  std::size_t inliers_min = 20;
  int iterations_max = 500;
  std::uint64_t seed = 1;
};

/// The round surface that most points support: near, and with their own direction, where reliable,
/// radial within 30 deg. Hypotheses take their axis from two points' directions or from the whole
/// cloud, their circle from three points, and are refined by robust least squares on the distances.
/// @errors TooFewObservations (fewer points than inliers_min), NoConsensus (nothing round: too few
/// inliers, or points over
///         less than 90 deg of the round, which a plane explains as well).
Result<Cylinder> find_cylinder(std::span<const Eigen::Vector3d> points_T,
                               const SurfaceNormals& normals,
                               const CylinderSearch& search);

}  // namespace polhode
