// What a growing map does not know of its own T: the part of a published pose's error that all
// landmarks share.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "geometry/pose.hpp"
#include "map/localise.hpp"

namespace polhode {

/// Three parts. The start: seen over a short turn, depth and turn can be exchanged for each other
/// (bas-relief ambiguity), so the start's turn is known to the same part as its depth. The part
/// shrinks as the body turns on; landmarks that were placed by the start leave slowly, so it does
/// so with the largest turn seen, not with its square, as the images would allow (measured: the
/// square is too quick by a factor of two on fifteen sequences). The walk: a map grows keyframe by
/// keyframe, each placed by the last ones with its own error. The re-anchoring: a start after a
/// loss is set into the T of before by the motion in between, and what that left open is a constant
/// of T from then on, of which no later image tells.
struct MapDrift {
  PoseCovariance walk = PoseCovariance::Zero();
  PoseCovariance fixed = PoseCovariance::Zero();  ///< what of it no closed loop lessens any more
  PoseCovariance reanchoring = PoseCovariance::Zero();
  std::uint32_t reanchored_keyframe =
      0;  ///< number of the first keyframe after the re-anchoring; 0: there is nothing to close
  Eigen::Matrix3d R_first_CT =
      Eigen::Matrix3d::Identity();  ///< attitude of the start's first frame
  double initial_turn_sigma = 0.0;  ///< of the start's turn, as a part of it
  double initial_sigma_mu = 0.0;    ///< of its depths
  double initial_turn_rad = 0.0;
  double turn_rad = 0.0;  ///< largest turn from R_first_CT so far
};

/// A start takes its turn.
/// @param depth_sigma  1-sigma of its depths, in its extents.
/// @param extent_mu    its extent in the map's unit.
void begin_drift(const Eigen::Matrix3d& R_first_CT,
                 double turn_rad,
                 double depth_sigma,
                 double extent_mu,
                 MapDrift* drift);

/// The body's motion has been fitted together with the map, and tells the turn so far to this part
/// of itself: depths are off by as much still, and with them the unit that comes of them.
void constrain_turn(double relative_sigma, double extent_mu, MapDrift* drift);

/// 1-sigma of a factor that all turns so far may have, less one.
[[nodiscard]] double turn_sigma(const MapDrift& drift);

/// 1-sigma of the map's unit, as a part of it, as the sides will have it that come into sight: what
/// was depth before is lateral then, and in it the start's turn is off by an angle.
[[nodiscard]] double unit_sigma(const MapDrift& drift);

/// A frame has its pose.
void widen_turn(const Pose& pose, MapDrift* drift);

/// A keyframe joins the map.
void add_keyframe_error(const LocalisedFrame& keyframe, MapDrift* drift);

/// A walk that is held at both ends, as by a closed loop, has at most a quarter of its variance, in
/// its middle. What was held before stays: a loop closes over many keyframes.
void fix_both_ends(MapDrift* drift);

/// A start after a loss has been set into T.
/// @param next_keyframe  number of its first keyframe.
void add_reanchoring(double attitude_sigma_rad,
                     double position_sigma_mu,
                     std::uint32_t next_keyframe,
                     MapDrift* drift);

/// The parts of the map before and after the re-anchoring have been fitted together: T is what is
/// between them, so half of the re-anchoring's sigma is left.
void close_reanchoring(MapDrift* drift);

/// What the map's growth says of T is said anew.
void replace_random_walk(const PoseCovariance& covariance, MapDrift* drift);

/// To be added to the covariance of a single pose.
PoseCovariance covariance(const MapDrift& drift);

}  // namespace polhode
