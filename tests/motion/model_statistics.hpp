// Many seeds of one case, against the truth and against the Cramer-Rao bound.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <memory>
#include <vector>

#include "free_body.hpp"
#include "motion/body_dynamics.hpp"
#include "motion/rigid_model.hpp"

namespace polhode {

/// The numbers that are compared: attitude error at the last pose (I), rate there (T), velocity of
/// the mass centre, its place in T, ln of both inertia ratios.
inline constexpr int kCompared = 14;
using Compared = Eigen::Matrix<double, kCompared, 1>;

inline double log_ratio(const Eigen::Vector3d& moments, Eigen::Index over) {
  Eigen::Vector3d sorted = moments;
  std::sort(sorted.data(), sorted.data() + 3);
  return std::log(sorted(over) / sorted(0));
}

/// Unknowns of the truth, perturbed one by one for the bound: attitude, rate, log of the three
/// second moments with the trace held, off-diagonals of the tensor, mass centre's path and place.
struct BoundCase {
  FreeBody body;
  std::size_t frames = 0;
  double interval_s = 1.0;
  PoseNoise noise;
};

inline FreeBody perturbed(const FreeBody& body, int k, double step) {
  FreeBody b = body;
  Eigen::Vector3d e = Eigen::Vector3d::Zero();
  e(k % 3) = step;
  if (k < 3) b.R_CT = so3_exp(e) * b.R_CT;
  if (k >= 3 && k < 6) b.w_T_rad_s += e;
  if (k >= 6 && k < 9) b.mass_centre_C += e;
  if (k >= 9 && k < 12) b.v_mass_centre_C += e;
  if (k >= 12 && k < 15) b.mass_centre_T += e;
  if (k >= 15 && k < 17) b.inertia(k - 14) *= std::exp(step);  // relative to the first moment
  if (k >= 17 && k < 20) {
    // Principal axes turned by e: the same motion seen from a body frame turned the other way, then
    // turned back in every output; here by turning the state into them.
    const Eigen::Matrix3d Q = so3_exp(e);
    b.R_CT = b.R_CT * Q;
    b.w_T_rad_s = Q.transpose() * b.w_T_rad_s;
    b.mass_centre_T = Q.transpose() * b.mass_centre_T;
  }
  return b;
}

/// What the perturbed body's poses are in the unperturbed T.
inline Pose in_T(const TruthSample& sample, int k, double step) {
  if (k < 17) return sample.pose;
  Eigen::Vector3d e = Eigen::Vector3d::Zero();
  e(k % 3) = step;
  // k % 3 of 17, 18, 19 is 2, 0, 1: all three axes.
  return {.R_CT = sample.pose.R_CT * so3_exp(e).transpose(), .p_CT = sample.pose.p_CT};
}

inline Compared outputs(const FreeBody& body,
                        const std::vector<TruthSample>& truth,
                        int k,
                        double step,
                        const Eigen::Matrix3d& R_last) {
  Compared y;
  Eigen::Vector3d e = Eigen::Vector3d::Zero();
  if (k >= 17) e(k % 3) = step;
  const Eigen::Matrix3d Q = so3_exp(e);
  y << so3_log(in_T(truth.back(), k, step).R_CT * R_last.transpose()), Q * truth.back().w_T_rad_s,
      body.v_mass_centre_C, Q * body.mass_centre_T, log_ratio(body.inertia, 1),
      log_ratio(body.inertia, 2);
  return y;
}

/// 1-sigma bound of each compared number from poses with white noise: differences of the simulator,
/// none of the fit's code.
inline Compared cramer_rao(const BoundCase& c) {
  constexpr int kUnknowns = 20;
  const auto truth = tumble(c.body, c.frames, c.interval_s);
  Eigen::Matrix<double, kUnknowns, kUnknowns> information;
  information.setZero();
  std::vector<Eigen::Matrix<double, 6, kUnknowns>> J(c.frames);
  Eigen::Matrix<double, kCompared, kUnknowns> G;
  for (int k = 0; k < kUnknowns; ++k) {
    const double step = k >= 3 && k < 6 ? 1e-8 : 1e-6;
    const FreeBody plus_body = perturbed(c.body, k, step);
    const FreeBody minus_body = perturbed(c.body, k, -step);
    const auto plus = tumble(plus_body, c.frames, c.interval_s);
    const auto minus = tumble(minus_body, c.frames, c.interval_s);
    for (std::size_t i = 0; i < c.frames; ++i) {
      const Pose a = in_T(plus[i], k, step);
      const Pose b = in_T(minus[i], k, -step);
      J[i].col(k) << so3_log(a.R_CT * b.R_CT.transpose()) / (2.0 * step),
          (a.p_CT - b.p_CT) / (2.0 * step);
    }
    G.col(k) = (outputs(plus_body, plus, k, step, truth.back().pose.R_CT) -
                outputs(minus_body, minus, k, -step, truth.back().pose.R_CT)) /
               (2.0 * step);
  }
  Eigen::Matrix<double, 6, 1> weight;
  weight << c.noise.attitude_rad.cwiseAbs2().cwiseInverse(),
      c.noise.position.cwiseAbs2().cwiseInverse();
  for (const auto& rows : J) information += rows.transpose() * weight.asDiagonal() * rows;
  const Eigen::Matrix<double, kUnknowns, kUnknowns> covariance = information.inverse();
  return (G * covariance * G.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
}

struct ModelStatistics {
  int seeds = 0;
  int accepted = 0;
  Compared rms = Compared::Zero();     ///< of the errors
  Compared sigma = Compared::Zero();   ///< mean of what was declared
  Compared inside = Compared::Zero();  ///< part of the errors within 1.96 sigma
};

inline Compared errors_of(const RigidModel& model, const FreeBody& body, const TruthSample& last) {
  const BodyDynamics described = describe_dynamics(model).value();
  Compared error;
  error << so3_log(model.reference.R_IT * last.pose.R_CT.transpose()),
      model.reference.w_T_rad_s - last.w_T_rad_s, model.path.segment<3>(3) - body.v_mass_centre_C,
      model.path.tail<3>() - body.mass_centre_T,
      std::log(described.middle_over_least.value) - log_ratio(body.inertia, 1),
      std::log(described.largest_over_least.value) - log_ratio(body.inertia, 2);
  return error;
}

inline Compared sigmas_of(const RigidModel& model) {
  const BodyDynamics described = describe_dynamics(model).value();
  Compared sigma;
  sigma << model.covariance.diagonal().head<6>().cwiseSqrt(),
      model.covariance.diagonal().segment<3>(kRotationUnknowns + 3).cwiseSqrt(),
      model.covariance.diagonal().tail<3>().cwiseSqrt(),
      described.middle_over_least.sigma / described.middle_over_least.value,
      described.largest_over_least.sigma / described.largest_over_least.value;
  return sigma;
}

/// @param declared  factor on the sigmas that the poses come with.
inline ModelStatistics run_seeds(const BoundCase& c, int seeds, double declared = 1.0) {
  const auto truth = tumble(c.body, c.frames, c.interval_s);
  auto snapshot = std::make_unique<MotionSnapshot>();
  auto workspace = std::make_unique<MotionWorkspace>();
  snapshot->body_radius = 0.5;
  ModelStatistics s;
  for (int seed = 0; seed < seeds; ++seed) {
    snapshot->poses.clear();
    for (PoseSample pose : observed(truth, c.noise, static_cast<std::uint64_t>(seed))) {
      pose.covariance *= declared * declared;
      (void)snapshot->poses.push_back(pose);
    }
    const RigidModel model = fit_rigid_model(*snapshot, *workspace);
    ++s.seeds;
    if (!model.accepted() || !model.translation_known) continue;
    ++s.accepted;
    const Compared error = errors_of(model, c.body, truth.back());
    const Compared sigma = sigmas_of(model);
    s.rms += error.cwiseAbs2();
    s.sigma += sigma;
    s.inside += (error.cwiseAbs().array() < 1.96 * sigma.array()).cast<double>().matrix();
  }
  s.rms = (s.rms / s.accepted).cwiseSqrt();
  s.sigma /= s.accepted;
  s.inside /= s.accepted;
  return s;
}

}  // namespace polhode
