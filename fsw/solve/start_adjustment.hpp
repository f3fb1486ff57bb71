// Joint adjustment of a map's start: all poses and points free, translations by inverse depth.
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

/// One image of one track. Lists of these are ordered by track, then by frame.
struct StartSighting {
  int frame = 0;
  int track = 0;
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();
  double sigma_normalised = 1.0;
};

/// A motion and a shape that explain the images, in the caller's arrays; a pose or a point that is
/// not known is left out. Only ratios are determined: the seven freedoms of the gauge are fixed by
/// `normalise_gauge`.
struct StartGeometryView {
  std::span<InverseDepthPose> poses;  ///< by frame
  std::span<std::uint8_t> posed;
  std::span<Eigen::Vector3d> points_T;  ///< by track, in units of the body's extent
  std::span<std::uint8_t> known;
};

enum class StartLoss {
  kCauchy,     ///< wide basin: width^2 log(1 + e / width^2)
  kTruncated,  ///< min(e, width^2), and no track more than 3 sigma above its mean: comparable
               ///< between hypotheses
};

struct StartAdjustmentOptions {
  int iterations_max = 20;
  StartLoss loss = StartLoss::kTruncated;
  double width_sigma = 4.0;  ///< two coordinates: 3e-4 of good residuals lie beyond
  double sigma_scale = 1.0;  ///< every sigma is multiplied by this
  double settled = 1e-3;     ///< stops when a step gains less chi-square than this
};

/// Residuals in units of the scaled sigma. Sightings that lie in unknown frames or tracks count as
/// lost.
struct StartFit {
  double cost = 0.0;  ///< robust; a lost sighting costs width^2 with the truncated loss, nothing
                      ///< with the other
  double chi2 = 0.0;  ///< of the inliers
  int inliers = 0;    ///< sightings within width_sigma, in tracks that fit as a whole
  int sightings = 0;
  int frames = 0;
  int points = 0;            ///< with two inliers or more
  double median = 0.0;       ///< squared residual of the sightings that are used
  double noise_scale = 0.0;  ///< the residuals' robust standard deviation over the scaled sigma
  int iterations = 0;
};

/// Linearised system, kept by the caller because of its size.
struct StartAdjustmentWorkspace {
  static constexpr std::size_t kSightings = 12000;  // 1500 tracks in 8 frames, or 375 in 32
  static constexpr int kCameraParameters = 6 * static_cast<int>(limits::kStartFrames);

  struct Block {
    Eigen::Matrix<double, 6, 3> W = Eigen::Matrix<double, 6, 3>::Zero();  ///< camera against point
    std::int32_t frame = -1;                                              ///< -1: without weight
  };
  struct PointBlock {
    Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
  };
  using CameraVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kCameraParameters, 1>;

  FixedVector<Block, kSightings> blocks;
  FixedVector<PointBlock, limits::kStartTracks> point_blocks;
  std::array<Eigen::Matrix<double, 6, 6>, limits::kStartFrames> camera_blocks;
  Eigen::MatrixXd reduced;  ///< 6 F square; factorised in place
  CameraVector camera_gradient;
  CameraVector camera_step;
  std::array<InverseDepthPose, limits::kStartFrames> trial_poses;
  std::array<Eigen::Vector3d, limits::kStartTracks> trial_points;
  FixedVector<double, kSightings> errors2;
};

/// Levenberg-Marquardt with the points eliminated (Schur complement); the gauge is left free and
/// held by the damping.
/// @param sightings  ordered by track; at most kSightings.
/// @param geometry   changed in place; never made worse.
/// @cost  iterations_max linear systems of 6 per frame. Deterministic.
/// @source Christy and Horaud, PAMI 1996 (parametrisation); Triggs et al., 2000 (elimination).
StartFit adjust_start(std::span<const StartSighting> sightings,
                      const StartGeometryView& geometry,
                      const StartAdjustmentOptions& options,
                      StartAdjustmentWorkspace* workspace);

/// The same figures without moving anything.
StartFit evaluate_start(std::span<const StartSighting> sightings,
                        const StartGeometryView& geometry,
                        const StartAdjustmentOptions& options,
                        StartAdjustmentWorkspace* workspace);

/// Cost of each track, 0 for one without sightings.
void start_track_costs(std::span<const StartSighting> sightings,
                       const StartGeometryView& geometry,
                       const StartAdjustmentOptions& options,
                       std::span<double> costs);

/// Pose of one frame from the known points, by at most `iterations_max` damped steps with Cauchy
/// loss.
/// @param sightings  of this frame only.
/// @return robust cost, or a negative number when fewer than four points are known.
double adjust_single_pose(std::span<const StartSighting> sightings,
                          const StartGeometryView& geometry,
                          const StartAdjustmentOptions& options,
                          InverseDepthPose* pose);

/// Normal equations at `geometry` with the points eliminated, undamped: fills workspace->blocks,
/// point_blocks and reduced.
bool reduced_camera_system(std::span<const StartSighting> sightings,
                           const StartGeometryView& geometry,
                           const StartAdjustmentOptions& options,
                           StartAdjustmentWorkspace* workspace);

/// Covariance of each known point (units of extent^2) in the gauge of `normalise_gauge`: centroid,
/// RMS extent and the attitude of the first frame exact. Only sightings within the truncation
/// count.
/// @param covariances  by track; zero where unknown.
/// @return false when the images do not determine the geometry; nothing is written then.
bool start_point_covariances(std::span<const StartSighting> sightings,
                             const StartGeometryView& geometry,
                             const StartAdjustmentOptions& options,
                             std::span<Eigen::Matrix3d> covariances,
                             StartAdjustmentWorkspace* workspace);

/// Same images, other gauge: T's axes parallel to the first known camera's, its origin in the
/// median of the points, RMS extent 1 (points beyond three median extents do not count for the
/// extent).
/// @return false, with nothing changed, when the origin would lie behind a camera or under four
/// points are known.
bool normalise_gauge(const StartGeometryView& geometry);

/// The depth-reversed twin (Necker): same images to the first order in extent / range.
void reverse_depth(const StartGeometryView& geometry);

}  // namespace polhode
