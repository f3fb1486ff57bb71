#include "synthetic/motions.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "geometry/so3.hpp"

namespace polhode::synthetic {
namespace {

Eigen::Vector3d euler_rate(const Eigen::Vector3d& inertia, const Eigen::Vector3d& w) {
  return -w.cross(inertia.cwiseProduct(w)).cwiseQuotient(inertia);
}

Eigen::Vector3d step_rate(const Eigen::Vector3d& inertia, const Eigen::Vector3d& w, double dt) {
  const Eigen::Vector3d k1 = euler_rate(inertia, w);
  const Eigen::Vector3d k2 = euler_rate(inertia, w + 0.5 * dt * k1);
  const Eigen::Vector3d k3 = euler_rate(inertia, w + 0.5 * dt * k2);
  const Eigen::Vector3d k4 = euler_rate(inertia, w + dt * k3);
  return w + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

}  // namespace

Eigen::Vector3d random_direction(Rng* rng) {
  return Eigen::Vector3d(rng->normal(), rng->normal(), rng->normal()).normalized();
}

Eigen::Matrix3d random_attitude(Rng* rng) {
  const Eigen::Vector4d q(rng->normal(), rng->normal(), rng->normal(), rng->normal());
  return Eigen::Quaterniond(q).normalized().toRotationMatrix();
}

Eigen::Vector3d direction_near_image_plane(double angle_rad, Rng* rng) {
  const double azimuth = 2.0 * std::numbers::pi * rng->uniform();
  const double height = std::sin(angle_rad) * (2.0 * rng->uniform() - 1.0);
  const double across = std::sqrt(1.0 - height * height);
  return {across * std::cos(azimuth), across * std::sin(azimuth), height};
}

Motion constant_turn(const ConstantTurn& turn, Rng* rng) {
  Motion motion;
  double time = 0.0;
  for (int f = 0; f < turn.frames; ++f) {
    motion.times_s.push_back(time);
    time += turn.interval_s * (1.0 + turn.time_jitter * (2.0 * rng->uniform() - 1.0));
  }
  for (const double t : motion.times_s) {
    const double part = t / motion.times_s.back();
    motion.poses.push_back({.R_CT = so3_exp(part * turn.turn_rad * turn.axis_C) * turn.R_first,
                            .p_CT = turn.p_first_m + part * (turn.p_last_m - turn.p_first_m)});
  }
  return motion;
}

Motion torque_free(const TorqueFree& start) {
  constexpr int kSteps = 100;
  Motion motion;
  Eigen::Matrix3d R = start.R_first;
  Eigen::Vector3d w = start.w_B_rad_s;
  for (int f = 0; f < start.frames; ++f) {
    const double time = f * start.interval_s;
    motion.times_s.push_back(time);
    motion.poses.push_back({.R_CT = R, .p_CT = start.p_first_m + time * start.v_C_m_s});
    const double dt = start.interval_s / kSteps;
    for (int i = 0; i < kSteps; ++i) {
      const Eigen::Vector3d w_middle = step_rate(start.inertia, w, 0.5 * dt);
      w = step_rate(start.inertia, w, dt);
      R = nearest_rotation(R * so3_exp(dt * w_middle));
    }
  }
  return motion;
}

}  // namespace polhode::synthetic
