#pragma once

#include <cstdint>

// One line per option: tests/structure/test_parameters.py reads these lines.
// clang-format off
namespace polhode {

/// `dynamics`: rigid-body fit where the poses support it, local fits elsewhere. `paper`: rates and speeds from pairs of
/// poses, as published.
enum class MotionMode : std::uint8_t { kDynamics = 0, kPaper = 1 };

/// What moves the target between frames.
enum class DynamicsKind : std::uint8_t {
  kTorqueFree = 0,  ///< nothing: a laboratory, or minutes in orbit
  kOrbit = 1,       ///< gravity gradient and Hill-Clohessy-Wiltshire; the observer is on a circular orbit
};

struct MotionOptions {
  MotionMode mode = MotionMode::kDynamics;
  DynamicsKind dynamics = DynamicsKind::kTorqueFree;
  // Chosen; bounds the time of a local fit.
  int window_poses_max = 64;            ///< poses of a local fit of the rate at most, 4 .. limits::kMotionPoses
  // 100 deg: the polynomial's first missing term is then 1 % of the motion's deviation from a constant rate.
  // Larger: less noise (the rate's sigma falls as the window to the power 1.5) and more of that error.
  double window_angle_max_rad = 1.75;   ///< body rotation over that window at most, 0.1 .. 3
  // Chosen; the time of a fit grows with it.
  int fit_poses_max = 300;              ///< poses of the rigid-body fit at most; when full, the older half is thinned, 16 .. limits::kMotionPoses
  double forgetting_s = 0.0;            ///< older poses leave the rigid-body fit; 0: none does, 0 .. 1000000
  // 500 km above the Earth: sqrt(398600 km^3/s^2 / (6878 km)^3).
  double mean_motion_rad_s = 0.0011;    ///< of the observer's circular orbit, 1e-5 .. 0.01
  double q_IH_w = 1.0;                  ///< takes Hill's frame (radial, along track, normal) to inertial axes at the epoch, -1 .. 1
  double q_IH_x = 0.0;                  ///< -1 .. 1
  double q_IH_y = 0.0;                  ///< -1 .. 1
  double q_IH_z = 0.0;                  ///< -1 .. 1
  std::int64_t orbit_epoch_ns = 0;      ///< time stamp at which q_IH holds

  bool operator==(const MotionOptions&) const = default;
};

}  // namespace polhode
