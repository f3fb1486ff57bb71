#include "map/drift.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/so3.hpp"

namespace polhode {

void begin_drift(const Eigen::Matrix3d& R_first_CT,
                 double turn_rad,
                 double depth_sigma,
                 double extent_mu,
                 MapDrift* drift) {
  // Converts depth_sigma, in extents, to a relative error: an extent is the RMS distance from the
  // centre, and depth is one of three directions.
  drift->R_first_CT = R_first_CT;
  drift->initial_turn_sigma = std::min(1.0, std::sqrt(3.0) * depth_sigma);
  drift->initial_sigma_mu = depth_sigma * extent_mu;
  drift->initial_turn_rad = turn_rad;
  drift->turn_rad = turn_rad;
}

void constrain_turn(double relative_sigma, double extent_mu, MapDrift* drift) {
  drift->initial_turn_sigma = std::min(1.0, relative_sigma);
  drift->initial_sigma_mu = drift->initial_turn_sigma / std::sqrt(3.0) * extent_mu;
  drift->initial_turn_rad = drift->turn_rad;
}

double turn_sigma(const MapDrift& drift) {
  return drift.turn_rad > 0.0 ? drift.initial_turn_sigma * drift.initial_turn_rad / drift.turn_rad
                              : 0.0;
}

double unit_sigma(const MapDrift& drift) {
  constexpr double kExchangedMost_rad = 0.5;  // largest of sin(t) cos(t)
  return turn_sigma(drift) * std::min(drift.initial_turn_rad, kExchangedMost_rad);
}

void widen_turn(const Pose& pose, MapDrift* drift) {
  drift->turn_rad = std::max(drift->turn_rad, rotation_angle_rad(pose.R_CT, drift->R_first_CT));
}

void add_keyframe_error(const LocalisedFrame& keyframe, MapDrift* drift) {
  drift->walk += with_clutter(keyframe);
}

void fix_both_ends(MapDrift* drift) {
  // A random walk fixed at both ends (Brownian bridge) has t (1 - t) of its variance.
  constexpr double kMiddleOfAFixedWalk = 0.25;
  drift->walk = drift->fixed + kMiddleOfAFixedWalk * (drift->walk - drift->fixed);
  drift->fixed = drift->walk;
}

void add_reanchoring(double attitude_sigma_rad,
                     double position_sigma_mu,
                     std::uint32_t next_keyframe,
                     MapDrift* drift) {
  widen_attitude(attitude_sigma_rad, &drift->reanchoring);
  widen_position(position_sigma_mu, &drift->reanchoring);
  drift->reanchored_keyframe = next_keyframe;
}

void close_reanchoring(MapDrift* drift) {
  constexpr double kBetween = 0.25;  // of the variance: half of the sigma
  drift->reanchoring *= kBetween;
  drift->reanchored_keyframe = 0;
}

void replace_random_walk(const PoseCovariance& covariance, MapDrift* drift) {
  drift->walk = covariance;
  drift->fixed = covariance;
}

PoseCovariance covariance(const MapDrift& drift) {
  PoseCovariance sum = drift.walk + drift.reanchoring;
  if (drift.turn_rad > 0.0) {
    widen_attitude(unit_sigma(drift), &sum);  // error of the initial rotation: the tangent of
                                              // lateral by depth
    widen_position(drift.initial_sigma_mu * drift.initial_turn_rad / drift.turn_rad, &sum);
  }
  return sum;
}

}  // namespace polhode
