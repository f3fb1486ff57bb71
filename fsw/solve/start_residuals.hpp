// What a start's sightings cost: shared by its adjustment and its gauge.
#pragma once

#include <span>

#include "solve/start_adjustment.hpp"

namespace polhode {

struct LossValue {
  double cost;
  double weight;  ///< derivative of the cost by the squared error
};

/// @param error2  squared residual in scaled sigma.
LossValue start_loss(double error2, const StartAdjustmentOptions& options);

/// Stands for the squared residual of a point behind the camera.
double behind_error2(const StartAdjustmentOptions& options);

/// Are the sighting's pose and point known?
bool usable(const StartGeometryView& geometry, const StartSighting& sighting);

/// End of the run of sightings that belong to the track at `begin`.
std::size_t track_end(std::span<const StartSighting> sightings, std::size_t begin);

struct TrackCost {
  double cost = 0.0;
  bool wrong = false;  ///< truncated loss only: the cost is the most that a track may cost
};

/// @param run            sightings of one track.
/// @param poses, points  stand in for those of the geometry.
TrackCost track_cost(std::span<const StartSighting> run,
                     std::span<const InverseDepthPose> poses,
                     std::span<const Eigen::Vector3d> points,
                     const StartGeometryView& geometry,
                     const StartAdjustmentOptions& options);

double total_cost(std::span<const StartSighting> sightings,
                  std::span<const InverseDepthPose> poses,
                  std::span<const Eigen::Vector3d> points,
                  const StartGeometryView& geometry,
                  const StartAdjustmentOptions& options);

}  // namespace polhode
