// Truth for the tests of motion: a torque-free rigid body that drifts in front of a resting camera,
// and noisy poses of it.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <vector>

#include "base/rng.hpp"
#include "geometry/so3.hpp"
#include "motion/pose_history.hpp"

namespace polhode {

struct FreeBody {
  Eigen::Vector3d inertia{1.0, 1.0, 1.0};  ///< principal moments about T's axes, any unit
  Eigen::Matrix3d R_CT = Eigen::Matrix3d::Identity();
  Eigen::Vector3d w_T_rad_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d mass_centre_C{0.0, 0.0, 10.0};
  Eigen::Vector3d v_mass_centre_C = Eigen::Vector3d::Zero();
  Eigen::Vector3d mass_centre_T = Eigen::Vector3d::Zero();  ///< seen from T's origin
};

struct TruthSample {
  std::int64_t timestamp_ns = 0;
  Pose pose;
  Eigen::Vector3d w_T_rad_s;
  Eigen::Vector3d v_C;  ///< of T's origin
};

inline Eigen::Vector3d euler_acceleration(const Eigen::Vector3d& inertia,
                                          const Eigen::Vector3d& w) {
  return -w.cross(inertia.cwiseProduct(w)).cwiseQuotient(inertia);
}

/// Steps of at most 0.01 rad: RK4 for the rate, exponential of its mean for the attitude; errors
/// below 1e-8 rad a turn.
inline void advance(FreeBody& body, double dt_s) {
  const int steps = 1 + static_cast<int>(body.w_T_rad_s.norm() * dt_s / 0.01);
  const double h = dt_s / steps;
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector3d w = body.w_T_rad_s;
    const Eigen::Vector3d k1 = euler_acceleration(body.inertia, w);
    const Eigen::Vector3d k2 = euler_acceleration(body.inertia, w + 0.5 * h * k1);
    const Eigen::Vector3d k3 = euler_acceleration(body.inertia, w + 0.5 * h * k2);
    const Eigen::Vector3d k4 = euler_acceleration(body.inertia, w + h * k3);
    body.w_T_rad_s = w + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    // Fourth-order Magnus step: Simpson's mean of the rate and the commutator of its ends.
    const Eigen::Vector3d end = euler_acceleration(body.inertia, body.w_T_rad_s);
    const Eigen::Vector3d middle = 0.5 * (w + body.w_T_rad_s) + h / 8.0 * (k1 - end);
    const Eigen::Vector3d mean = (w + 4.0 * middle + body.w_T_rad_s) / 6.0;
    body.R_CT = body.R_CT * so3_exp(h * mean + h * h / 12.0 * w.cross(body.w_T_rad_s));
  }
  body.mass_centre_C += dt_s * body.v_mass_centre_C;
}

inline TruthSample truth_of(const FreeBody& body, std::int64_t timestamp_ns) {
  const Eigen::Vector3d arm_C = body.R_CT * body.mass_centre_T;
  return {.timestamp_ns = timestamp_ns,
          .pose = {.R_CT = body.R_CT, .p_CT = body.mass_centre_C - arm_C},
          .w_T_rad_s = body.w_T_rad_s,
          .v_C = body.v_mass_centre_C - (body.R_CT * body.w_T_rad_s).cross(arm_C)};
}

inline std::vector<TruthSample> tumble(FreeBody body, std::size_t frames, double interval_s) {
  std::vector<TruthSample> truth;
  for (std::size_t i = 0; i < frames; ++i) {
    truth.push_back(truth_of(
        body, 1'700'000'000'000'000'000 + std::llround(1e9 * interval_s * static_cast<double>(i))));
    advance(body, interval_s);
  }
  return truth;
}

struct PoseNoise {
  Eigen::Vector3d attitude_rad{
      1e-3, 1e-3, 3e-4};  ///< 1-sigma about C's axes: depth makes x and y the weak ones
  Eigen::Vector3d position{1e-3, 1e-3, 1e-2};
};

inline PoseSample observed(const TruthSample& truth, const PoseNoise& noise, Rng& rng) {
  PoseSample sample{
      .timestamp_ns = truth.timestamp_ns, .pose = {}, .covariance = PoseCovariance::Zero()};
  Eigen::Vector3d phi;
  for (Eigen::Index k = 0; k < 3; ++k) {
    phi(k) = noise.attitude_rad(k) * rng.normal();
    sample.pose.p_CT(k) = truth.pose.p_CT(k) + noise.position(k) * rng.normal();
    sample.covariance(k, k) = noise.attitude_rad(k) * noise.attitude_rad(k);
    sample.covariance(3 + k, 3 + k) = noise.position(k) * noise.position(k);
  }
  sample.pose.R_CT = so3_exp(phi) * truth.pose.R_CT;
  return sample;
}

inline std::vector<PoseSample> observed(const std::vector<TruthSample>& truth,
                                        const PoseNoise& noise,
                                        std::uint64_t seed) {
  Rng rng(seed, 17);
  std::vector<PoseSample> samples;
  for (const TruthSample& sample : truth) {
    samples.push_back(observed(sample, noise, rng));
  }
  return samples;
}

inline constexpr double kDegree_rad = 0.017453292519943295;

/// The paper's case: a rod that turns about its long axis with a slight wobble, 10 s a frame,
/// approaching.
inline FreeBody paper_body() {
  FreeBody body;
  body.inertia = {0.47, 0.47, 0.02};
  body.w_T_rad_s = Eigen::Vector3d(0.0, 0.1, 1.0) * kDegree_rad;
  body.R_CT << 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0;
  body.mass_centre_C = {0.0, 0.0, 20.0};
  body.v_mass_centre_C = {0.0, 0.0, -0.0045};
  return body;
}

/// Three different moments, all axes excited.
inline FreeBody asymmetric_body(double rate_rad_s) {
  FreeBody body;
  body.inertia = {1.0, 1.6, 2.1};
  body.w_T_rad_s = rate_rad_s * Eigen::Vector3d(0.3, 0.9, 0.4).normalized();
  body.R_CT = so3_exp({0.4, -0.9, 0.3});
  body.mass_centre_C = {0.3, -0.2, 12.0};
  body.v_mass_centre_C = {0.01, -0.005, -0.02};
  body.mass_centre_T = {0.05, -0.02, 0.03};
  return body;
}

}  // namespace polhode
