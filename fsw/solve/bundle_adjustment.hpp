// Joint adjustment of poses and points to their images.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "geometry/reprojection.hpp"

namespace polhode {

struct BundleObservation {
  std::int32_t pose = 0;   ///< index into poses
  std::int32_t point = 0;  ///< index into points
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();
  double sigma_normalised = 1.0;
};

/// Poses and points are changed in place. At least one pose must be fixed; where only one is, the
/// scale is held by the damping alone and the caller re-aligns.
struct BundleProblem {
  std::span<InverseDepthPose> poses;
  std::span<const std::uint8_t> pose_fixed;  ///< 1: held
  std::span<Eigen::Vector3d> points_T;
  std::span<const std::uint8_t> point_fixed;
  std::span<const BundleObservation> observations;
};

struct BundleOptions {
  int iterations_max = 10;
  double cauchy_sigma = 2.0;  ///< at this many sigma a residual has half its weight
};

struct BundleReport {
  bool usable = false;  ///< false: poses and points are as they were
  int iterations = 0;
  double cost_before = 0.0;  ///< half the robust sum of squares, in sigma
  double cost_after = 0.0;
};

/// @cost at most iterations_max Levenberg-Marquardt steps, dense Schur complement, one thread.
/// Deterministic.
/// @source Triggs et al., Bundle Adjustment - A Modern Synthesis, 2000; by way of Ceres.
BundleReport adjust_bundle(const BundleProblem& problem, const BundleOptions& options);

}  // namespace polhode
