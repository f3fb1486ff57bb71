// Intersection of a ray with the target's surface, by the landmarks about it.
#pragma once

#include <Eigen/Core>
#include <span>

#include "base/result.hpp"
#include "geometry/pose.hpp"

namespace polhode {

/// Intersection of a ray of the named frame with the target.
struct SurfaceHit {
  double depth_mu = 0.0;  ///< z in C
  /// 1-sigma along the ray: of the surface, of the choice of the surface, and of the map's bend.
  double sigma_mu = 0.0;
  Eigen::Vector3d p_C = Eigen::Vector3d::Zero();
};

/// A frame's pose and the landmarks seen in it. Only those: hidden faces have landmarks on the same
/// rays. Map units.
struct ScaleView {
  Pose pose;
  std::span<const Eigen::Vector3d> landmarks_T;
  /// 1-sigma of each landmark along its ray, by its observations; empty: taken as 0.
  std::span<const double> sigmas_mu{};
  /// 1-sigma of the scale of all differences in depth, relative: rotation and depth of a young map
  /// trade off (bas-relief ambiguity).
  double relief_sigma = 0.0;
};

/// Depth of the surface on a ray, from the landmarks nearest to it in the image. The inverse depth
/// of a plane in space is linear in the image. Candidates are planes through triples of the nearest
/// landmarks; they must face the camera and have landmarks next to the ray. The nearest one with
/// enough support is refined by least squares, with weights that fall with the distance from the
/// ray. Without such a plane: the nearest landmark's depth, with a wide sigma.
/// Landmarks about the ray that lie on another surface widen the sigma, by their distances from ray
/// and surface. Errors of neighbours are correlated, as the same keyframes placed them: the sigma
/// is no smaller than theirs.
/// @param ray  normalised image point (undistorted).
/// @errors TooFewObservations (under 3 landmarks in front of the camera), Degenerate (the ray
/// passes the target: no landmark near it in the image).
/// @cost   O(landmarks).
Result<SurfaceHit> hit_surface(const ScaleView& view, const Eigen::Vector2d& ray);

}  // namespace polhode
