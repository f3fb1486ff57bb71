// Pose of the target in one frame from landmarks of known position.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "base/result.hpp"
#include "geometry/pose.hpp"

namespace polhode {

struct PoseObservation {
  Eigen::Vector3d p_T = Eigen::Vector3d::Zero();
  Eigen::Vector2d normalised = Eigen::Vector2d::Zero();
  double sigma_normalised =
      1.0;  ///< 1-sigma of each coordinate, the landmark's own uncertainty included
};

struct AbsolutePoseOptions {
  int iterations_max = 200;  ///< finds three inliers among 32 % with 99.9 % probability
  int inliers_min = 12;      ///< four times the least that determine a pose
  std::uint64_t seed = 0;
  std::uint64_t stream = 0;
};

struct AbsolutePose {
  Pose pose;
  PoseCovariance covariance =
      PoseCovariance::Zero();  ///< scaled up by chi2 / dof where that exceeds 1
  int inliers = 0;
  double chi2 = 0.0;  ///< over the inliers, 2 * inliers - 6 degrees of freedom
};

/// Gate of inliers, in sigma squared: 4 sigma (decision 0024). Normal errors of two coordinates lie
/// beyond with a probability of 3e-4. Feature positions have heavier tails; the robust loss lowers
/// their weights between 2 and 4 sigma.
inline constexpr double kInlierChi2 = 16.0;

/// Consensus of P3P hypotheses, then three rounds of choosing inliers and a robust fit (Cauchy) to
/// them.
/// @param inlier  out, one byte per observation.
/// @param hint    tried as the first hypothesis when given.
/// @errors TooFewObservations, NoConsensus.
/// @source P3P: Kneip, Scaramuzza, Siegwart, CVPR 2011, via OpenGV.
Result<AbsolutePose> absolute_pose(std::span<const PoseObservation> observations,
                                   const Pose* hint,
                                   const AbsolutePoseOptions& options,
                                   std::span<std::uint8_t> inlier);

/// Flags the observations that agree with a pose within kInlierChi2.
/// @return their number.
int mark_inliers(const Pose& pose,
                 std::span<const PoseObservation> observations,
                 std::span<std::uint8_t> inlier);

/// Robust fit (Cauchy at 2 sigma) from `pose` to the observations flagged in `inlier`.
/// @errors TooFewObservations (under 4), Degenerate.
Result<AbsolutePose> refine_pose(std::span<const PoseObservation> observations,
                                 const Pose& pose,
                                 std::span<const std::uint8_t> inlier);

/// The most likely pose where the observations alone may be too few: three rounds of selecting
/// inliers, within the prior's covariance at first, and a robust fit to them and the prior.
/// @param prior       predicted pose, with `prior_covariance` of (phi, dp).
/// @param inlier      out, one byte per observation.
/// @return covariance: of the observations, with a tenth of the prior's information so that it
/// stays finite. A motion estimated from the result is then not confirmed by its own prediction.
/// @errors TooFewObservations (fewer agree than options.inliers_min), Degenerate.
Result<AbsolutePose> pose_with_prior(std::span<const PoseObservation> observations,
                                     const Pose& prior,
                                     const PoseCovariance& prior_covariance,
                                     const AbsolutePoseOptions& options,
                                     std::span<std::uint8_t> inlier);

}  // namespace polhode
