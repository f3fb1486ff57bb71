// Families of starts, each member drawn from a seed: what a start of the map meets in practice.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "synthetic/initial_problem.hpp"

namespace polhode::synthetic {

enum class InitialFamily {
  kFar,  ///< 3 deg subtended, cylinder, box or satellite, 15 to 60 deg of turn, every point in
         ///< every frame
  kFarPartial,   ///< the same with points that come and go, outliers, lost images
  kTumbling,     ///< torque-free, 6 to 10 deg a frame, 4 to 16 deg subtended, outliers
  kPanel,        ///< one flat panel
  kDish,         ///< concave: the convexity cue is wrong
  kTranslation,  ///< no turn: the body drifts across a wide field
  kNoisy,        ///< three times the noise that the caller claims
  kStatic,       ///< nothing moves but the noise
  kRandom,       ///< tracks without any body
  kLumpy,        ///< independent slow drifts of each track: smooth, not rigid
};
inline constexpr std::array kInitialFamilies = {InitialFamily::kFar,
                                                InitialFamily::kFarPartial,
                                                InitialFamily::kTumbling,
                                                InitialFamily::kPanel,
                                                InitialFamily::kDish,
                                                InitialFamily::kTranslation,
                                                InitialFamily::kNoisy,
                                                InitialFamily::kStatic,
                                                InitialFamily::kRandom,
                                                InitialFamily::kLumpy};
inline constexpr std::array kInitialFamilyNames = {"far",
                                                   "far partial",
                                                   "tumbling",
                                                   "panel",
                                                   "dish",
                                                   "drift",
                                                   "noisy",
                                                   "static",
                                                   "random",
                                                   "lumpy"};
constexpr bool has_body(InitialFamily family) {
  return family != InitialFamily::kStatic && family != InitialFamily::kRandom &&
         family != InitialFamily::kLumpy;
}

struct InitialScenario {
  Motion motion;
  std::vector<Track> tracks;
  double sigma_normalised = 0.0;  ///< as claimed
};

namespace detail {

inline constexpr double kDegree = std::numbers::pi / 180.0;
inline constexpr double kFocal_px = 2667.0;

inline double between(double low, double high, Rng* rng) {
  return low + (high - low) * rng->uniform();
}

inline Body any_body(int points, Rng* rng) {
  switch (rng->below(3)) {
    case 0:
      return cylinder(points, 0.15, 0.4, rng);
    case 1:
      return box(points, {0.3, 0.4, 0.5}, rng);
    default:
      return satellite(points, rng);
  }
}

inline Body body_of(InitialFamily family, Rng* rng) {
  switch (family) {
    case InitialFamily::kPanel:
      return panel(160, 0.6, 0.4, rng);
    case InitialFamily::kDish:
      return dish(120, 0.25, 0.12, rng);
    case InitialFamily::kTumbling:
      return any_body(500, rng);
    default:
      return any_body(260, rng);
  }
}

/// Attitude that shows the +z side at some slant.
inline Eigen::Matrix3d facing(double slant_rad, Rng* rng) {
  const Eigen::Matrix3d front = so3_exp({std::numbers::pi, 0.0, 0.0});
  const Eigen::Vector3d axis = direction_near_image_plane(0.0, rng);
  const Eigen::Matrix3d spin = so3_exp({0.0, 0.0, between(0.0, 6.28, rng)});
  return so3_exp(axis * slant_rad) * front * spin;
}

inline Motion motion_of(InitialFamily family, const Body& body, Rng* rng) {
  double alpha_deg = 3.0;
  if (family == InitialFamily::kTumbling) {
    alpha_deg = between(4.0, 16.0, rng);
  } else if (family == InitialFamily::kPanel || family == InitialFamily::kTranslation) {
    alpha_deg = between(6.0, 14.0, rng);
  } else if (family == InitialFamily::kDish || family == InitialFamily::kNoisy) {
    alpha_deg = between(3.0, 10.0, rng);
  }
  const double range_m = 2.0 * radius_m(body) / (alpha_deg * kDegree);
  const Eigen::Vector3d p(
      between(-0.05, 0.05, rng) * range_m, between(-0.05, 0.05, rng) * range_m, range_m);
  if (family == InitialFamily::kTumbling) {
    const Eigen::Vector3d w = random_direction(rng) * between(6.0, 10.0, rng) * kDegree / 10.0;
    return torque_free({.frames = 10,
                        .inertia = {1.0, between(1.2, 2.0, rng), between(2.0, 2.4, rng)},
                        .w_B_rad_s = w,
                        .R_first = random_attitude(rng),
                        .p_first_m = p,
                        .v_C_m_s = random_direction(rng) * 5e-4 * range_m});
  }
  ConstantTurn turn{.frames = 6 + static_cast<int>(rng->below(7)), .time_jitter = 0.3};
  turn.turn_rad = between(15.0, 60.0, rng) * kDegree;
  turn.axis_C = direction_near_image_plane(40.0 * kDegree, rng);
  turn.R_first = random_attitude(rng);
  turn.p_first_m = p;
  turn.p_last_m = p + random_direction(rng) * between(0.0, 0.04, rng) * range_m;
  if (family == InitialFamily::kPanel || family == InitialFamily::kDish) {
    turn.R_first = facing(between(0.1, 0.7, rng), rng);
    turn.turn_rad = between(15.0, 40.0, rng) * kDegree;
  } else if (family == InitialFamily::kTranslation) {
    turn.turn_rad = 0.0;
    const Eigen::Vector3d side = direction_near_image_plane(0.3, rng);
    turn.p_first_m = p - 0.25 * range_m * side;
    turn.p_last_m = p + 0.25 * range_m * side;
  } else if (family == InitialFamily::kStatic) {
    turn.turn_rad = 0.0;
    turn.p_last_m = p;
  }
  return constant_turn(turn, rng);
}

inline Imaging imaging_of(InitialFamily family, Rng* rng) {
  Imaging imaging{.focal_px = kFocal_px, .noise_px = 0.5};
  if (family == InitialFamily::kFarPartial || family == InitialFamily::kTumbling ||
      family == InitialFamily::kPanel || family == InitialFamily::kDish) {
    imaging.outlier_tracks = between(0.0, 0.2, rng);
    imaging.wrong_matches = between(0.0, 0.05, rng);
    imaging.lost = between(0.0, 0.15, rng);
  } else if (family == InitialFamily::kNoisy) {
    imaging.noise_px = 1.5;
  } else if (family == InitialFamily::kFar) {
    imaging.all_frames_only = true;
  }
  return imaging;
}

inline void drift_apart(Rng* rng, std::vector<Track>* tracks) {
  for (Track& track : *tracks) {
    track.outlier = true;
    const Eigen::Vector2d step(rng->normal() * 3.0 / kFocal_px, rng->normal() * 3.0 / kFocal_px);
    const Eigen::Vector2d bend(rng->normal() * 0.3 / kFocal_px, rng->normal() * 0.3 / kFocal_px);
    for (Observation& o : track.observations) {
      o.normalised += step * o.frame + bend * (o.frame * o.frame);
    }
  }
}

}  // namespace detail

inline InitialScenario make_initial_scenario(InitialFamily family, std::uint64_t seed) {
  Rng rng(seed, 77U + static_cast<std::uint64_t>(family));
  InitialScenario s;
  const Body body = detail::body_of(family, &rng);
  const InitialFamily moving = family == InitialFamily::kLumpy ? InitialFamily::kStatic : family;
  s.motion = detail::motion_of(moving, body, &rng);
  s.sigma_normalised = 0.5 / detail::kFocal_px;
  if (family == InitialFamily::kRandom) {
    s.tracks =
        random_tracks(90, static_cast<int>(s.motion.times_s.size()), 80.0, detail::kFocal_px, &rng);
    return s;
  }
  s.tracks = track_points(body, s.motion, detail::imaging_of(family, &rng), &rng);
  if (family == InitialFamily::kLumpy) {
    detail::drift_apart(&rng, &s.tracks);
  }
  return s;
}

}  // namespace polhode::synthetic
