// What a start's sightings cost: shared by its adjustment and its gauge.
#pragma once

#include <span>

#include "solve/cauchy_loss.hpp"
#include "solve/start_problem.hpp"

namespace polhode {

/// Of the truncated loss: what a lost sighting costs, too.
inline double truncated_max(const StartAdjustmentOptions& options) {
  return options.width_sigma * options.width_sigma;
}

/// Derivative of a sighting's cost by its squared residual.
/// @param error2  squared residual in scaled sigma.
inline double start_weight(double error2, const StartAdjustmentOptions& options) {
  if (options.loss == StartLoss::kTruncated) {
    return error2 < truncated_max(options) ? 1.0 : 0.0;
  }
  return cauchy_weight(error2, options.width_sigma);
}

/// Stands for the squared residual of a point behind the camera.
inline double behind_error2(const StartAdjustmentOptions& options) {
  constexpr double kBehindWidths2 = 1e4;
  return kBehindWidths2 * options.width_sigma * options.width_sigma;
}

/// Are the sighting's pose and point known?
inline bool usable(const StartGeometryView& geometry, const StartSighting& sighting) {
  return geometry.posed[static_cast<std::size_t>(sighting.frame)] != 0 &&
         geometry.known[static_cast<std::size_t>(sighting.track)] != 0;
}

/// End of the run of sightings that belong to the track at `begin`.
std::size_t track_end(std::span<const StartSighting> sightings, std::size_t begin);

struct TrackCost {
  double cost = 0.0;
  bool wrong = false;  ///< truncated loss only: the cost is the most that a track may cost
};

/// @param run  sightings of one track.
TrackCost track_cost(std::span<const StartSighting> run,
                     const StartGeometryView& geometry,
                     const StartAdjustmentOptions& options);

/// @param poses, points_T  stand in for those of the geometry.
double total_cost(std::span<const StartSighting> sightings,
                  std::span<const InverseDepthPose> poses,
                  std::span<const Eigen::Vector3d> points_T,
                  const StartGeometryView& geometry,
                  const StartAdjustmentOptions& options);

/// The figures of a fit without moving anything.
StartFit evaluate_start(std::span<const StartSighting> sightings,
                        const StartGeometryView& geometry,
                        const StartAdjustmentOptions& options,
                        StartAdjustmentWorkspace* workspace);

/// Cost of each track, 0 for one without sightings.
void start_track_costs(std::span<const StartSighting> sightings,
                       const StartGeometryView& geometry,
                       const StartAdjustmentOptions& options,
                       std::span<double> costs);

}  // namespace polhode
