// Costs of an initialisation's observations: shared by its adjustment and its gauge.
#pragma once

#include <span>

#include "solve/cauchy_loss.hpp"
#include "solve/initial_problem.hpp"

namespace polhode {

/// Bound of the truncated loss, and the cost of a lost observation.
inline double truncated_max(const InitialAdjustmentOptions& options) {
  return options.width_sigma * options.width_sigma;
}

/// Derivative of an observation's cost by its squared residual.
/// @param error2  squared residual in scaled sigma.
inline double initial_weight(double error2, const InitialAdjustmentOptions& options) {
  if (options.loss == InitialLoss::kTruncated) {
    return error2 < truncated_max(options) ? 1.0 : 0.0;
  }
  return cauchy_weight(error2, options.width_sigma);
}

/// Squared residual of a point behind the camera.
inline double behind_error2(const InitialAdjustmentOptions& options) {
  // In widths, a hundred: worse than any point that can still converge. Chosen; finite, so that
  // costs stay comparable.
  constexpr double kBehindWidths2 = 1e4;
  return kBehindWidths2 * options.width_sigma * options.width_sigma;
}

/// Are the observation's pose and point known?
inline bool usable(const InitialGeometryView& geometry, const TrackObservation& observation) {
  return geometry.posed[static_cast<std::size_t>(observation.frame)] != 0 &&
         geometry.known[static_cast<std::size_t>(observation.track)] != 0;
}

/// End of the run of observations that belong to the track at `begin`.
std::size_t track_end(std::span<const TrackObservation> observations, std::size_t begin);

struct TrackCost {
  double cost = 0.0;
  bool wrong = false;  ///< with the truncated loss only: the track's cost is at its bound
};

/// @param run  observations of one track.
TrackCost track_cost(std::span<const TrackObservation> run,
                     const InitialGeometryView& geometry,
                     const InitialAdjustmentOptions& options);

/// @param poses, points_T  used in place of the geometry's.
double total_cost(std::span<const TrackObservation> observations,
                  std::span<const InverseDepthPose> poses,
                  std::span<const Eigen::Vector3d> points_T,
                  const InitialGeometryView& geometry,
                  const InitialAdjustmentOptions& options);

/// Statistics of a fit; changes nothing.
InitialFit evaluate_initial(std::span<const TrackObservation> observations,
                            const InitialGeometryView& geometry,
                            const InitialAdjustmentOptions& options,
                            InitialAdjustmentWorkspace* workspace);

/// Cost of each track, 0 for one without observations.
void initial_track_costs(std::span<const TrackObservation> observations,
                         const InitialGeometryView& geometry,
                         const InitialAdjustmentOptions& options,
                         std::span<double> costs);

}  // namespace polhode
