// Drift of the map frame T: the part of a published pose's error that all landmarks share.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "geometry/pose.hpp"
#include "map/localise.hpp"

namespace polhode {

/// Three parts. Initialisation: over a short rotation, depth and rotation trade off (bas-relief
/// ambiguity), so the relative error of the initial rotation is that of the depth. It shrinks in
/// proportion to the largest rotation seen. Its square would be too quick by a factor of two on
/// fifteen sequences, as initial landmarks leave slowly. Random walk: each keyframe is placed by
/// the last ones, with its own error. Re-anchoring: after a loss the new map is aligned with T by
/// the predicted motion; the error of that alignment is constant and not observable later.
struct MapDrift {
  PoseCovariance walk = PoseCovariance::Zero();
  PoseCovariance fixed = PoseCovariance::Zero();  ///< its part that no later loop closure reduces
  PoseCovariance reanchoring = PoseCovariance::Zero();
  std::uint32_t reanchored_keyframe =
      0;  ///< number of the first keyframe after the re-anchoring; 0: there is nothing to close
  Eigen::Matrix3d R_first_CT =
      Eigen::Matrix3d::Identity();  ///< attitude of the initialisation's first frame
  double initial_turn_sigma = 0.0;  ///< relative, of the initial rotation
  double initial_sigma_mu = 0.0;    ///< of the initial depths
  double initial_turn_rad = 0.0;
  double turn_rad = 0.0;  ///< largest turn from R_first_CT so far
};

/// Sets the drift of a new initialisation.
/// @param turn_rad     largest rotation in it.
/// @param depth_sigma  1-sigma of its depths, in its extents.
/// @param extent_mu    its extent in the map's unit.
void begin_drift(const Eigen::Matrix3d& R_first_CT,
                 double turn_rad,
                 double depth_sigma,
                 double extent_mu,
                 MapDrift* drift);

/// Bounds the error of the rotation so far, after a joint fit of motion and map. Depths and the
/// unit keep the same relative error.
/// @param relative_sigma  of the rotation so far.
void constrain_turn(double relative_sigma, double extent_mu, MapDrift* drift);

/// 1-sigma of the scale error of all rotations so far, relative.
[[nodiscard]] double turn_sigma(const MapDrift& drift);

/// 1-sigma of the map's unit, relative, on aspects that come into view later: there the initial
/// depth is lateral, and the error of the initial rotation is an angle in it.
[[nodiscard]] double unit_sigma(const MapDrift& drift);

/// Updates the largest rotation by a frame's pose.
void widen_turn(const Pose& pose, MapDrift* drift);

/// Adds a new keyframe's error to the random walk.
void add_keyframe_error(const LocalisedFrame& keyframe, MapDrift* drift);

/// Fixes the random walk at both ends, as a loop closure does: at most a quarter of the variance is
/// left, in the middle. The part fixed before stays: a loop closes over many keyframes.
void fix_both_ends(MapDrift* drift);

/// Adds the error of a re-anchoring: the alignment of a new map with T after a loss.
/// @param next_keyframe  number of the new map's first keyframe.
void add_reanchoring(double attitude_sigma_rad,
                     double position_sigma_mu,
                     std::uint32_t next_keyframe,
                     MapDrift* drift);

/// Halves the re-anchoring's sigma, after a joint fit of the map's parts before and after it: T is
/// then midway between the two.
void close_reanchoring(MapDrift* drift);

/// Replaces the covariance of the random walk.
void replace_random_walk(const PoseCovariance& covariance, MapDrift* drift);

/// To be added to the covariance of a single pose.
PoseCovariance covariance(const MapDrift& drift);

}  // namespace polhode
