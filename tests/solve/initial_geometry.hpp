// A start of known geometry for the tests of the solvers: points on a box, a few frames, exact or
// noisy images.
#pragma once

#include <numbers>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"
#include "solve/initial_adjustment.hpp"
#include "synthetic/bodies.hpp"
#include "synthetic/motions.hpp"

namespace polhode::testing {

struct InitialGeometry {
  std::vector<InverseDepthPose> poses;
  std::vector<std::uint8_t> posed;
  std::vector<Eigen::Vector3d> points_T;
  std::vector<std::uint8_t> known;
  std::vector<TrackObservation> observations;
  std::vector<double> times_s;

  InitialGeometryView view() { return {poses, posed, points_T, known}; }
};

struct InitialGeometryOptions {
  int points = 40;
  int frames = 6;
  double turn_rad = 0.6;
  double extent_over_range = 0.05;
  double sigma = 1e-4;
  double noise = 0.0;  ///< in sigma
  bool flat = false;
  bool on_axis =
      false;  ///< no drift across the image: weak perspective then errs by extent / range alone
};

inline InitialGeometry make_initial_geometry(const InitialGeometryOptions& options,
                                             std::uint64_t seed) {
  Rng rng(seed, 5);
  const synthetic::Body body = options.flat ? synthetic::panel(options.points, 1.5, 1.0, &rng)
                                            : synthetic::box(options.points, {1.0, 1.2, 1.5}, &rng);
  synthetic::ConstantTurn turn{.frames = options.frames, .turn_rad = options.turn_rad};
  turn.axis_C = synthetic::direction_near_image_plane(0.4, &rng);
  turn.R_first = options.flat ? so3_exp({0.5, 0.2, 0.1}) : synthetic::random_attitude(&rng);
  const double range = 1.0 / options.extent_over_range;
  const double side = options.on_axis ? 0.0 : 0.02 * range;
  turn.p_first_m = {side, -0.5 * side, range};
  turn.p_last_m = {0.0, side, 1.02 * range};
  const synthetic::Motion motion = synthetic::constant_turn(turn, &rng);
  InitialGeometry g;
  g.times_s = motion.times_s;
  for (const Pose& pose : motion.poses) {
    g.poses.push_back(to_inverse_depth(pose));
    g.posed.push_back(1);
  }
  for (int i = 0; i < options.points; ++i) {
    g.points_T.push_back(body[static_cast<std::size_t>(i)].p_B);
    g.known.push_back(1);
    for (int f = 0; f < options.frames; ++f) {
      TrackObservation s{.frame = f, .track = i, .sigma_normalised = options.sigma};
      Eigen::Vector2d seen = Eigen::Vector2d::Zero();
      (void)reproject(g.poses[static_cast<std::size_t>(f)], g.points_T.back(), &seen);
      s.normalised =
          seen + options.sigma * options.noise * Eigen::Vector2d(rng.normal(), rng.normal());
      g.observations.push_back(s);
    }
  }
  return g;
}

/// Moves everything by about `angle_rad` and `part` of an extent.
inline void disturb(double angle_rad, double part, std::uint64_t seed, InitialGeometry* g) {
  Rng rng(seed, 6);
  for (InverseDepthPose& pose : g->poses) {
    pose.R_CT = so3_exp(angle_rad * synthetic::random_direction(&rng)) * pose.R_CT;
    pose.uvs.head<2>() += 0.02 * pose.uvs.z() * Eigen::Vector2d(rng.normal(), rng.normal());
    pose.uvs.z() *= 1.0 + 0.02 * rng.normal();
  }
  for (Eigen::Vector3d& p_T : g->points_T) {
    p_T += part * Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal());
  }
}

}  // namespace polhode::testing
