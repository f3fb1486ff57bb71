// Motions of a body in front of the camera, exact at each frame.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/rng.hpp"
#include "geometry/pose.hpp"

namespace polhode::synthetic {

/// Pose of the body's axes B in the camera at each frame: `Pose` with T = B.
struct Motion {
  std::vector<double> times_s;
  std::vector<Pose> poses;
};

Eigen::Matrix3d random_attitude(Rng* rng);
Eigen::Vector3d random_direction(Rng* rng);
/// Unit vector in C within `angle_rad` of the image plane.
Eigen::Vector3d direction_near_image_plane(double angle_rad, Rng* rng);

struct ConstantTurn {
  int frames = 8;
  double interval_s = 10.0;
  double time_jitter = 0.0;  ///< of each interval, as a part of it
  double turn_rad = 0.0;     ///< over all frames, about `axis_C`
  Eigen::Vector3d axis_C = Eigen::Vector3d::UnitY();
  Eigen::Matrix3d R_first = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_first_m = Eigen::Vector3d(0.0, 0.0, 10.0);
  Eigen::Vector3d p_last_m = Eigen::Vector3d(0.0, 0.0, 10.0);
};
/// Constant rate about an axis that is fixed in the camera; the origin moves along a straight line.
Motion constant_turn(const ConstantTurn& turn, Rng* rng);

struct TorqueFree {
  int frames = 20;
  double interval_s = 10.0;
  Eigen::Vector3d inertia = Eigen::Vector3d(1.0, 2.0, 2.5);  ///< principal moments, any unit
  Eigen::Vector3d w_B_rad_s = Eigen::Vector3d(0.01, 0.002, 0.001);
  Eigen::Matrix3d R_first = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_first_m = Eigen::Vector3d(0.0, 0.0, 10.0);
  Eigen::Vector3d v_C_m_s = Eigen::Vector3d::Zero();
};
/// Euler's equations by fourth-order Runge-Kutta in 100 steps a frame.
Motion torque_free(const TorqueFree& start);

}  // namespace polhode::synthetic
