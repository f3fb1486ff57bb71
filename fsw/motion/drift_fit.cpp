#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/so3.hpp"
#include "motion/paper.hpp"

namespace polhode {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix63 = Eigen::Matrix<double, 6, 3>;

// Noise of the attitudes looks like motion by a centre-of-mass offset c. A direction is known where
// its information is this many times that of noise alone. Chosen: a body that has rotated by a
// radian has a million times.
constexpr double kOverNoiseMin = 10.0;
// Least noise, in parts of the information: keeps the noise matrix regular for exact attitudes.
constexpr double kNoiseFloor = 1e-6;

/// Normal equations in the drift x = (p0, v span) and the centre-of-mass offset c.
struct System {
  Matrix6 H_xx = Matrix6::Zero();
  Matrix63 H_xc = Matrix63::Zero();
  Eigen::Matrix3d H_cc = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d noise_cc =
      Eigen::Matrix3d::Zero();  ///< mean contribution of the attitudes' noise to H_cc
  Vector6 g_x = Vector6::Zero();
  Eigen::Vector3d g_c = Eigen::Vector3d::Zero();
  double square = 0.0;
};

/// E[hat(phi)^T W hat(phi)] for phi of the given covariance.
Eigen::Matrix3d expected_square(const Eigen::Matrix3d& W, const Eigen::Matrix3d& covariance_phi) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (Eigen::Index k = 0; k < 3; ++k) {
    for (Eigen::Index l = 0; l < 3; ++l) {
      sum += covariance_phi(k, l) * hat(Eigen::Vector3d::Unit(k)).transpose() * W *
             hat(Eigen::Vector3d::Unit(l));
    }
  }
  return sum;
}

bool accumulate(const PoseSample& sample,
                double time,
                const Eigen::Vector3d& origin_C,
                System& system) {
  const Eigen::LLT<Eigen::Matrix3d> llt(
      Eigen::Matrix3d(sample.covariance.bottomRightCorner<3, 3>()));
  const Eigen::Matrix3d W = llt.solve(Eigen::Matrix3d::Identity());
  if (llt.info() != Eigen::Success || !W.allFinite()) {
    return false;
  }
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), time * Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d& R_CT = sample.pose.R_CT;
  const Eigen::Vector3d value = sample.pose.p_CT - origin_C;
  system.H_xx += J.transpose() * W * J;
  system.H_xc -= J.transpose() * W * R_CT;
  system.H_cc += R_CT.transpose() * W * R_CT;
  system.noise_cc +=
      R_CT.transpose() * expected_square(W, sample.covariance.topLeftCorner<3, 3>()) * R_CT;
  system.g_x += J.transpose() * W * value;
  system.g_c -= R_CT.transpose() * W * value;
  system.square += value.dot(W * value);
  return true;
}

struct Lever {
  Eigen::Vector3d c_T = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

/// c with the drift eliminated, with its prior, and without the information of attitude noise.
Lever solve_lever(const Eigen::Matrix3d& information,
                  const Eigen::Vector3d& g,
                  const Eigen::Matrix3d& noise,
                  double prior_sigma) {
  const Eigen::Matrix3d floored =
      noise + kNoiseFloor * information.trace() * Eigen::Matrix3d::Identity();
  // V with V^T floored V = 1 and V^T information V diagonal: whiten by the noise, then rotate.
  const Eigen::Matrix3d L = floored.llt().matrixL();
  const Eigen::Matrix3d inverse_L = L.inverse();
  const Eigen::Matrix3d whitened = inverse_L * information * inverse_L.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(whitened);
  const Eigen::Matrix3d V = inverse_L.transpose() * eigen.eigenvectors();
  Eigen::Matrix3d H = V.transpose() * V / (prior_sigma * prior_sigma);
  Eigen::Vector3d rhs = V.transpose() * g;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double over_noise = eigen.eigenvalues()(k);
    const bool known = over_noise >= kOverNoiseMin;
    H(k, k) += known ? over_noise - 1.0 : 0.0;
    rhs(k) = known ? rhs(k) : 0.0;
  }
  const Eigen::Matrix3d covariance = V * H.inverse() * V.transpose();
  return {.c_T = V * (H.inverse() * rhs), .covariance = covariance};
}

}  // namespace

Result<DriftFit> fit_drift(std::span<const PoseSample> poses, double body_radius) {
  if (poses.size() < 4) {
    return ErrorCode::kTooFewObservations;
  }
  if (!(body_radius > 0.0) || !std::isfinite(body_radius)) {
    return ErrorCode::kBadParameter;
  }
  const double span_s = seconds_between(poses.front().timestamp_ns, poses.back().timestamp_ns);
  if (!(span_s > 0.0)) {
    return ErrorCode::kDegenerate;
  }
  System system;
  for (const PoseSample& sample : poses) {
    const double time = seconds_between(poses.front().timestamp_ns, sample.timestamp_ns) / span_s;
    if (!accumulate(sample, time, poses.front().pose.p_CT, system)) {
      return ErrorCode::kDegenerate;
    }
  }
  const Matrix6 inverse_xx = system.H_xx.llt().solve(Matrix6::Identity());
  const Matrix63 by_c = inverse_xx * system.H_xc;
  const Eigen::Matrix3d information = system.H_cc - system.H_xc.transpose() * by_c;
  const Eigen::Vector3d g_c = system.g_c - by_c.transpose() * system.g_x;
  const Lever lever = solve_lever(information, g_c, system.noise_cc, body_radius);
  const Vector6 x = inverse_xx * system.g_x - by_c * lever.c_T;
  const Matrix6 covariance_x = inverse_xx + by_c * lever.covariance * by_c.transpose();
  if (!x.allFinite() || !covariance_x.allFinite() || !lever.covariance.allFinite()) {
    return ErrorCode::kDegenerate;
  }
  const double chi2 = system.square - 2.0 * (x.dot(system.g_x) + lever.c_T.dot(system.g_c)) +
                      x.dot(system.H_xx * x) + 2.0 * x.dot(system.H_xc * lever.c_T) +
                      lever.c_T.dot(system.H_cc * lever.c_T);
  DriftFit fit;
  fit.chi2_per_dof = std::max(0.0, chi2) / (3.0 * static_cast<double>(poses.size()) - 6.0);
  const double widening = std::max(1.0, fit.chi2_per_dof);
  fit.p0_C = poses.front().pose.p_CT + x.head<3>();
  fit.v_C = x.tail<3>() / span_s;
  fit.c_T = lever.c_T;
  fit.covariance_v_C = widening * covariance_x.bottomRightCorner<3, 3>() / (span_s * span_s);
  fit.covariance_c_T = widening * lever.covariance;
  fit.speed = fit.v_C.norm();
  return fit;
}

}  // namespace polhode
