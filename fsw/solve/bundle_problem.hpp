// Input and result of a bundle adjustment: poses, points and observations.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "geometry/reprojection.hpp"

namespace polhode {

struct BundleObservation {
  std::int32_t pose = 0;   ///< index into poses
  std::int32_t point = 0;  ///< index into points
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();
  double sigma_normalised = 1.0;
};

/// Prior of a pose: of (phi, uvs) about `mean`.
struct PosePrior {
  std::int32_t pose = 0;
  InverseDepthPose mean;
  Eigen::Matrix<double, 6, 6> information = Eigen::Matrix<double, 6, 6>::Zero();
};

/// Link of three or four successive poses by the rates of rotation between them, which change
/// slowly. With Q = R_IC R_CT, the sum of factors[m] log(Q_(m+1) Q_m^T) is zero. Its sigma for each
/// axis is the whole turn over turn_rad: in proportion, so that a map whose depths and rotations
/// are all too small has the same cost.
struct RateLink {
  // Of three rates, with two changes.
  static constexpr std::size_t kPoses = 4;
  // Noise of poses, added to the whole turn in squares: else a link would constrain a body at rest
  // too strongly. 0.6 deg.
  static constexpr double kTurnLeast_rad = 0.01;
  FixedVector<std::int32_t, kPoses> poses;         ///< indices
  std::array<double, kPoses - 1> factors_1_rad{};  ///< of the turn from each pose to the next
  double turn_rad = 1.0;                           ///< the whole turn when the link was made
};

/// Capacities of an adjustment.
struct BundleLimits {
  static constexpr std::size_t kPoses = limits::kKeyframes;
  static constexpr std::size_t kPoints = limits::kLandmarks;
  static constexpr std::size_t kObservations = limits::kAdjustmentObservations;
};

/// Bound on the heap of an adjustment: Ceres's residuals and Jacobian, its points, and the dense
/// system of all poses. tests/memory measures it.
constexpr std::size_t adjustment_bytes_max(std::size_t observations, std::size_t poses) {
  // Bytes: 700 were measured with six or more views a point, 860 with three, the least mean number.
  constexpr std::size_t kOfObservation = 870;
  // Bytes: 1.1 million were measured.
  constexpr std::size_t kOfAll = 1'200'000;
  const std::size_t unknowns = 6 * poses;
  return kOfObservation * observations + sizeof(double) * unknowns * unknowns + kOfAll;
}

/// Poses and points are changed in place; at most as many as in BundleLimits. Where fewer than
/// two poses are fixed, only the damping constrains the rest of the gauge: the caller re-aligns.
struct BundleProblem {
  std::span<InverseDepthPose> poses;
  std::span<const std::uint8_t> pose_fixed;  ///< 1: constant
  std::span<Eigen::Vector3d> points_T;
  std::span<const std::uint8_t> point_fixed;
  std::span<const BundleObservation> observations;
  std::span<const PosePrior> priors = {};
  std::span<const Eigen::Matrix3d> R_IC = {};  ///< the camera's attitude at each pose, for links
  std::span<const RateLink> links = {};
};

struct BundleOptions {
  int iterations_max = 10;    ///< a bound: it ends when the cost has settled
  double cauchy_sigma = 2.0;  ///< at this many sigma a residual has half its weight
  /// Points beyond this number are left out; they follow the poses afterwards.
  std::size_t observations_max = BundleLimits::kObservations;
};

struct BundleReport {
  bool usable = false;  ///< false: poses and points are as they were
  int iterations = 0;
  double cost_before = 0.0;  ///< half the robust sum of squares, in sigma
  double cost_after = 0.0;
};

}  // namespace polhode
