// Poses, points and their images, with the memory that an adjustment of them needs.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

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

/// Poses and points are changed in place; at most as many as BundleWorkspace holds. Where fewer
/// than two poses are fixed, only the damping constrains the rest of the gauge: the caller
/// re-aligns.
struct BundleProblem {
  std::span<InverseDepthPose> poses;
  std::span<const std::uint8_t> pose_fixed;  ///< 1: constant
  std::span<Eigen::Vector3d> points_T;
  std::span<const std::uint8_t> point_fixed;
  std::span<const BundleObservation> observations;
  std::span<const PosePrior> priors = {};
};

struct BundleOptions {
  int iterations_max = 10;    ///< a bound: it ends when the cost has settled
  double cauchy_sigma = 2.0;  ///< at this many sigma a residual has half its weight
};

struct BundleReport {
  bool usable = false;  ///< false: poses and points are as they were
  int iterations = 0;
  double cost_before = 0.0;  ///< half the robust sum of squares, in sigma
  double cost_after = 0.0;
};

/// Working memory of an adjustment, some 4 MB; contents mean nothing between calls.
struct BundleWorkspace {
  static constexpr std::size_t kPoses = limits::kKeyframes;
  static constexpr std::size_t kPoints = limits::kLandmarks;
  static constexpr std::size_t kObservations = limits::kAdjustmentObservations;
  static constexpr std::size_t kUnknowns = 6 * kPoses;  // (phi, uvs) each

  std::array<std::int32_t, kPoses> block_of_pose{};  ///< -1: constant
  std::array<std::int32_t, kPoints + 1> first_of_point{};
  std::array<std::int32_t, kObservations>
      by_point{};  ///< observations, those of one point together
  std::array<InverseDepthPose, kPoses> trial_poses{};
  std::array<Eigen::Vector3d, kPoints> trial_points{};
  std::array<Eigen::Matrix<double, 6, 6>, kPoses> camera_blocks{};
  alignas(64) std::array<double, kUnknowns * kUnknowns> reduced{};  ///< lower triangle
  alignas(64) std::array<double, kUnknowns> gradient{};
  alignas(64) std::array<double, kUnknowns> step{};
};

}  // namespace polhode
