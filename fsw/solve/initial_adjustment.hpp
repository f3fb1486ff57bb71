// Bundle adjustment of an initialisation: all poses and points free, translations by inverse depth.
#pragma once

#include <Eigen/Core>
#include <span>

#include "solve/initial_problem.hpp"
#include "solve/initial_residuals.hpp"

namespace polhode {

/// Levenberg-Marquardt with the points eliminated (Schur complement). Only the damping constrains
/// the gauge.
/// @param observations  ordered by track; at most kInitialObservations.
/// @param geometry   changed in place; never made worse.
/// @cost  iterations_max linear systems of 6 per frame. Deterministic.
/// @source Christy and Horaud, PAMI 1996 (parametrisation); Triggs et al., 2000 (elimination).
InitialFit adjust_initial(std::span<const TrackObservation> observations,
                          const InitialGeometryView& geometry,
                          const InitialAdjustmentOptions& options,
                          InitialAdjustmentWorkspace* workspace);

/// Pose of one frame from the known points, by at most `iterations_max` damped steps with Cauchy
/// loss.
/// @param observations  of this frame only.
/// @return robust cost, or a negative number when fewer than four points are known or the cost
/// cannot be evaluated.
double adjust_single_pose(std::span<const TrackObservation> observations,
                          const InitialGeometryView& geometry,
                          const InitialAdjustmentOptions& options,
                          InverseDepthPose* pose);

/// Normal equations at `geometry` with the points eliminated, undamped: fills workspace->blocks,
/// point_blocks and reduced.
bool reduced_camera_system(std::span<const TrackObservation> observations,
                           const InitialGeometryView& geometry,
                           const InitialAdjustmentOptions& options,
                           InitialAdjustmentWorkspace* workspace);

/// Covariance of each known point (units of extent^2) in the gauge of `normalise_gauge`: centroid,
/// RMS extent and the attitude of the first frame exact. Only observations within the truncation
/// count.
/// @param covariances  by track; zero where unknown.
/// @return false when the images do not determine the geometry; nothing is written then.
bool initial_point_covariances(std::span<const TrackObservation> observations,
                               const InitialGeometryView& geometry,
                               const InitialAdjustmentOptions& options,
                               std::span<Eigen::Matrix3d> covariances,
                               InitialAdjustmentWorkspace* workspace);

/// Changes the gauge, not the images: T's axes parallel to the first known camera's, its origin in
/// the median of the points, RMS extent 1 without the points beyond three median extents.
/// @return false, with nothing changed, when the origin would lie behind a camera or under four
/// points are known.
bool normalise_gauge(const InitialGeometryView& geometry);

/// Replaces the geometry by its depth-reversed solution (Necker ambiguity): same images to first
/// order in extent / range.
void apply_depth_reversal(const InitialGeometryView& geometry);

}  // namespace polhode
