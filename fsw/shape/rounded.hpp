// A body without edges, as an alternative to a cylinder: an ellipsoid through the cloud.
#pragma once

#include <Eigen/Core>
#include <span>

#include "base/result.hpp"
#include "shape/cylinder.hpp"

namespace polhode {

/// (p - centre)' shape (p - centre) = 1.
struct Ellipsoid {
  Eigen::Vector3d centre_T = Eigen::Vector3d::Zero();
  Eigen::Matrix3d shape = Eigen::Matrix3d::Identity();  ///< positive definite

  /// Distance from the surface, positive outside, to first order (Sampson).
  [[nodiscard]] double distance(const Eigen::Vector3d& point_T) const;
};

/// By reweighted least squares on the quadric's equation.
/// @param band  at half of it a distance has half its weight
/// @errors TooFewObservations (under 20 points), Degenerate (the quadric is no ellipsoid, or one
/// so long that it is a cylinder).
Result<Ellipsoid> fit_ellipsoid(std::span<const Eigen::Vector3d> points_T, double band);

/// Cross-validation: does an ellipsoid fitted to every other point explain the rest better than the
/// cylinder does?
/// @param band  within which a point is explained
bool is_rounded(std::span<const Eigen::Vector3d> points_T, const Cylinder& cylinder, double band);

}  // namespace polhode
