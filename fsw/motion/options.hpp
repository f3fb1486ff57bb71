#pragma once

#include <cstdint>

// One line an option:
// clang-format off
namespace polhode {

/// `dynamics`: rigid-body fit where the data bear it out, local fits elsewhere. `paper`: rates and speeds from pairs of
/// poses, as published.
enum class MotionMode : std::uint8_t { kDynamics = 0, kPaper = 1 };

/// What moves the target between frames.
enum class DynamicsKind : std::uint8_t {
  kTorqueFree = 0,  ///< nothing: a laboratory, or minutes in orbit
  kOrbit = 1,       ///< gravity gradient and Hill-Clohessy-Wiltshire, the observer being on a circular orbit
};

// One line an option:
struct MotionOptions {
  MotionMode mode = MotionMode::kDynamics;
  DynamicsKind dynamics = DynamicsKind::kTorqueFree;
  int window_poses_max = 64;            ///< poses that a local rate is fitted to at most, 4 .. limits::kMotionPoses
  /// Body rotation over the window at most, 0.1 .. 3. At 1.75 (100 deg) the polynomial's first missing term is 1 % of the
  /// motion's bend; the rate's sigma falls as the window to the power 1.5.
  double window_angle_max_rad = 1.75;
  int fit_poses_max = 300;              ///< poses that the dynamics are fitted to at most; the older half is thinned, 16 .. 512
  double forgetting_s = 0.0;            ///< poses older than this are not fitted; 0: none is forgotten
  double mean_motion_rad_s = 0.0011;    ///< of the observer's orbit, 1e-5 .. 0.01
  double q_IH_w = 1.0;                  ///< Hill's frame (radial, along track, normal) in inertial axes at the epoch
  double q_IH_x = 0.0;
  double q_IH_y = 0.0;
  double q_IH_z = 0.0;
  std::int64_t orbit_epoch_ns = 0;      ///< the time that q_IH holds at

  bool operator==(const MotionOptions&) const = default;
};

}  // namespace polhode
