// Types of the initial adjustment: observations of tracks, geometry, options and workspace.
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

/// Unaligned, to save memory: there are tens of thousands of them.
using PackedVector2d = Eigen::Matrix<double, 2, 1, Eigen::DontAlign>;

/// One observation of one track. Lists of these are ordered by track, then by frame.
struct TrackObservation {
  int frame = 0;
  int track = 0;
  PackedVector2d normalised = PackedVector2d::Zero();
  double sigma_normalised = 1.0;
};

/// Poses and points of a hypothesis, in the caller's arrays. Those not marked `posed` or `known`
/// are left out. The seven gauge freedoms are fixed by `normalise_gauge`.
struct InitialGeometryView {
  std::span<InverseDepthPose> poses;  ///< by frame
  std::span<std::uint8_t> posed;
  std::span<Eigen::Vector3d> points_T;  ///< by track, in units of the body's extent
  std::span<std::uint8_t> known;
};

enum class InitialLoss {
  kCauchy,     ///< wide basin: width^2 log(1 + e / width^2)
  kTruncated,  ///< min(e, width^2), and no track more than 3 sigma above its mean: comparable
               ///< between hypotheses
};

struct InitialAdjustmentOptions {
  int iterations_max = 20;  ///< a bound: it ends when a step gains less than `settled`
  InitialLoss loss = InitialLoss::kTruncated;
  double width_sigma = 4.0;      ///< 3e-4 of normal residuals of two coordinates lie beyond
  double sigma_scale = 1.0;      ///< every sigma is multiplied by this
  bool rotations_fixed = false;  ///< attitudes stay, translations and points move
  double settled = 1e-3;         ///< stops when a step gains less chi-square: a 30th of a sigma
};

/// Residuals in units of the scaled sigma. Observations in unknown frames or tracks count as
/// lost.
struct InitialFit {
  double cost = 0.0;  ///< robust; a lost observation costs width^2 with the truncated loss, nothing
                      ///< with the other
  double chi2 = 0.0;  ///< of the inliers
  int inliers = 0;    ///< observations within width_sigma, in tracks that fit as a whole
  int observations = 0;
  int redundant = 0;  ///< observations beyond the first two of their tracks
  int agreeing = 0;   ///< of these, within width_sigma
  int frames = 0;
  int points = 0;            ///< with two inliers or more
  double median = 0.0;       ///< squared residual of the observations that are used
  double noise_scale = 0.0;  ///< the residuals' robust standard deviation over the scaled sigma
  int iterations = 0;
};

/// Linearised system, kept by the caller because of its size.
struct InitialAdjustmentWorkspace {
  static constexpr std::size_t kInitialObservations = 12000;  // 1500 tracks x 8 frames, 375 x 32
  static constexpr int kCameraParameters =
      6 * static_cast<int>(limits::kInitialFrames);  // (phi, uvs)

  struct Block {
    Eigen::Matrix<double, 6, 3> W = Eigen::Matrix<double, 6, 3>::Zero();  ///< camera against point
    std::int32_t frame = -1;                                              ///< -1: without weight
  };
  struct PointBlock {
    Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
  };
  using CameraVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kCameraParameters, 1>;

  FixedVector<Block, kInitialObservations> blocks;
  FixedVector<PointBlock, limits::kInitialTracks> point_blocks;
  std::array<Eigen::Matrix<double, 6, 6>, limits::kInitialFrames> camera_blocks;
  Eigen::MatrixXd reduced;  ///< 6 rows and columns per frame; factorised in place
  CameraVector camera_gradient;
  CameraVector camera_step;
  std::array<InverseDepthPose, limits::kInitialFrames> trial_poses;
  std::array<Eigen::Vector3d, limits::kInitialTracks> trial_points;
  FixedVector<double, kInitialObservations> errors2;
};

}  // namespace polhode
