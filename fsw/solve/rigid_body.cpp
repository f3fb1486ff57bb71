#include "solve/rigid_body.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "geometry/so3.hpp"

namespace polhode {
namespace {

// Least ratio of second moments: raises those of a tensor that noise made unphysical, or of a
// sheet, to a body with a finite logarithm. A hundredth is a thickness of a tenth.
constexpr double kMomentFloor = 0.01;
// Difference of logarithms below which sinh(x) / x is taken to be 1, right to 4e-12; avoids 0 / 0.
constexpr double kApartMin = 1e-5;
// Least eigenvalue, so that the floor is not zero.
constexpr double kMomentMin = 1e-300;

/// dS by d log S in the direction `direction` (Daleckii and Krein), V and l being those of log S.
Eigen::Matrix3d exponential_derivative(const Eigen::Matrix3d& V,
                                       const Eigen::Vector3d& l,
                                       const Eigen::Matrix3d& direction) {
  Eigen::Matrix3d inner = V.transpose() * direction * V;
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j < 3; ++j) {
      const double apart = l(i) - l(j);
      const double middle = std::exp(0.5 * (l(i) + l(j)));
      inner(i, j) *=
          std::abs(apart) > kApartMin ? 2.0 * middle * std::sinh(0.5 * apart) / apart : middle;
    }
  }
  return V * inner * V.transpose();
}

/// The linear system of the errors: d/dt dw = A dw + B.
struct ErrorRate {
  Eigen::Matrix3d A;
  RotationJacobian B;
};

ErrorRate error_rate(const Inertia& inertia,
                     const Orbit& orbit,
                     const RotationState& at,
                     const RotationJacobian& attitude_error_I) {
  const Eigen::Vector3d& w = at.w_T_rad_s;
  const Eigen::Vector3d w_dot = angular_acceleration(inertia, orbit, at);
  ErrorRate rate;
  rate.A = inertia.J_inverse * (hat(inertia.J_T * w) - hat(w) * inertia.J_T);
  rate.B.setZero();
  Eigen::Vector3d u = Eigen::Vector3d::Zero();
  double torque_factor = 0.0;
  if (orbit.active()) {
    const Eigen::Vector3d radial_I = orbit.R_IH_at(at.time_s).col(0);
    u = at.R_IT.transpose() * radial_I;
    torque_factor = 3.0 * orbit.mean_motion_rad_s * orbit.mean_motion_rad_s;
    const Eigen::Matrix3d by_u = hat(u) * inertia.J_T - hat(inertia.J_T * u);
    rate.B = torque_factor * (inertia.J_inverse * by_u * at.R_IT.transpose() * hat(radial_I)) *
             attitude_error_I;
  }
  for (Eigen::Index k = 0; k < 5; ++k) {
    const Eigen::Matrix3d& dJ = inertia.J_by_shape[static_cast<std::size_t>(k)];
    rate.B.col(6 + k) +=
        inertia.J_inverse * (torque_factor * u.cross(dJ * u) - dJ * w_dot - w.cross(dJ * w));
  }
  return rate;
}

struct Nodes {
  RotationState start;
  RotationState middle;
  RotationState end;
};

/// Rates by Runge-Kutta; the middle by the cubic through both ends; attitudes by Magnus' series.
Nodes step(const Inertia& inertia, const Orbit& orbit, double h_s, const RotationState& start) {
  const Eigen::Vector3d& w = start.w_T_rad_s;
  RotationState at = start;
  const Eigen::Vector3d k1 = angular_acceleration(inertia, orbit, at);
  at.time_s = start.time_s + 0.5 * h_s;
  at.w_T_rad_s = w + 0.5 * h_s * k1;
  if (orbit.active()) {
    at.R_IT = start.R_IT * so3_exp(0.5 * h_s * (w + 0.25 * h_s * k1));
  }
  const Eigen::Vector3d k2 = angular_acceleration(inertia, orbit, at);
  at.w_T_rad_s = w + 0.5 * h_s * k2;
  const Eigen::Vector3d k3 = angular_acceleration(inertia, orbit, at);
  at.time_s = start.time_s + h_s;
  at.w_T_rad_s = w + h_s * k3;
  if (orbit.active()) {
    at.R_IT = start.R_IT * so3_exp(h_s * (w + 0.5 * h_s * k2));
  }
  const Eigen::Vector3d k4 = angular_acceleration(inertia, orbit, at);
  Nodes nodes{.start = start, .middle = start, .end = at};
  nodes.end.w_T_rad_s = w + h_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  const Eigen::Vector3d& w_end = nodes.end.w_T_rad_s;
  const Eigen::Vector3d k_end = angular_acceleration(inertia, orbit, nodes.end);
  const Eigen::Vector3d w_middle = 0.5 * (w + w_end) + h_s / 8.0 * (k1 - k_end);
  nodes.middle.time_s = start.time_s + 0.5 * h_s;
  nodes.middle.w_T_rad_s = w_middle;
  nodes.middle.R_IT = start.R_IT * so3_exp(h_s / 24.0 * (5.0 * w + 8.0 * w_middle - w_end));
  nodes.end.R_IT = start.R_IT * so3_exp(h_s / 6.0 * (w + 4.0 * w_middle + w_end) +
                                        h_s * h_s / 12.0 * w.cross(w_end));
  return nodes;
}

void step_derivative(const Inertia& inertia,
                     const Orbit& orbit,
                     double h_s,
                     const Nodes& nodes,
                     RotationDerivative& d) {
  const RotationJacobian W = d.rate_T;
  const RotationJacobian E_middle = d.attitude_I + 0.5 * h_s * (nodes.start.R_IT * W);
  const RotationJacobian E_end = d.attitude_I + h_s * (nodes.start.R_IT * W);
  const ErrorRate at_start = error_rate(inertia, orbit, nodes.start, d.attitude_I);
  const ErrorRate at_middle = error_rate(inertia, orbit, nodes.middle, E_middle);
  const ErrorRate at_end = error_rate(inertia, orbit, nodes.end, E_end);
  const RotationJacobian k1 = at_start.A * W + at_start.B;
  const RotationJacobian k2 = at_middle.A * (W + 0.5 * h_s * k1) + at_middle.B;
  const RotationJacobian k3 = at_middle.A * (W + 0.5 * h_s * k2) + at_middle.B;
  const RotationJacobian k4 = at_end.A * (W + h_s * k3) + at_end.B;
  d.rate_T = W + h_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  const RotationJacobian k_end = at_end.A * d.rate_T + at_end.B;
  const RotationJacobian W_middle = 0.5 * (W + d.rate_T) + h_s / 8.0 * (k1 - k_end);
  // d phi / dt = R dw: Simpson's rule.
  d.attitude_I +=
      h_s / 6.0 *
      (nodes.start.R_IT * W + 4.0 * (nodes.middle.R_IT * W_middle) + nodes.end.R_IT * d.rate_T);
}

}  // namespace

Eigen::Matrix3d shape_basis(int k) {
  Eigen::Matrix3d B = Eigen::Matrix3d::Zero();
  const double off = std::sqrt(0.5);
  switch (k) {
    case 0:
      B.diagonal() << off, -off, 0.0;
      break;
    case 1:
      B.diagonal() = Eigen::Vector3d(1.0, 1.0, -2.0) / std::sqrt(6.0);
      break;
    case 2:
      B(0, 1) = B(1, 0) = off;
      break;
    case 3:
      B(0, 2) = B(2, 0) = off;
      break;
    default:
      B(1, 2) = B(2, 1) = off;
      break;
  }
  return B;
}

Inertia inertia_of(const InertiaShape& shape) {
  Eigen::Matrix3d log_S = Eigen::Matrix3d::Zero();
  for (int k = 0; k < 5; ++k) {
    log_S += shape(k) * shape_basis(k);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(log_S);
  const Eigen::Matrix3d& V = eigen.eigenvectors();
  const Eigen::Vector3d& l = eigen.eigenvalues();
  const Eigen::Vector3d s = l.array().exp();
  const Eigen::Vector3d moments(s(1) + s(2), s(2) + s(0), s(0) + s(1));
  const double size = moments.maxCoeff();
  Inertia inertia;
  inertia.J_T = V * (moments / size).asDiagonal() * V.transpose();
  inertia.J_inverse = V * (size * moments.cwiseInverse()).asDiagonal() * V.transpose();
  for (int k = 0; k < 5; ++k) {
    const Eigen::Matrix3d dS = exponential_derivative(V, l, shape_basis(k)) / size;
    inertia.J_by_shape[static_cast<std::size_t>(k)] = dS.trace() * Eigen::Matrix3d::Identity() - dS;
  }
  return inertia;
}

InertiaShape shape_of(const Eigen::Matrix3d& J_T) {
  const Eigen::Matrix3d S = 0.5 * J_T.trace() * Eigen::Matrix3d::Identity() - J_T;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(0.5 * (S + S.transpose()));
  const Eigen::Vector3d& s = eigen.eigenvalues();
  const double floor = kMomentFloor * std::max(s.maxCoeff(), kMomentMin);
  const Eigen::Vector3d l = s.cwiseMax(floor).array().log();
  const Eigen::Matrix3d log_S =
      eigen.eigenvectors() * l.asDiagonal() * eigen.eigenvectors().transpose();
  InertiaShape shape;
  for (int k = 0; k < 5; ++k) {
    shape(k) = log_S.cwiseProduct(shape_basis(k)).sum();
  }
  return shape;
}

Eigen::Matrix3d Orbit::R_IH_at(double time_s) const {
  return R_IH * so3_exp({0.0, 0.0, mean_motion_rad_s * time_s});
}

RotationDerivative RotationDerivative::at_reference() {
  RotationDerivative d;
  d.attitude_I.leftCols<3>().setIdentity();
  d.rate_T.middleCols<3>(3).setIdentity();
  return d;
}

Eigen::Vector3d angular_acceleration(const Inertia& inertia,
                                     const Orbit& orbit,
                                     const RotationState& state) {
  Eigen::Vector3d torque = -state.w_T_rad_s.cross(inertia.J_T * state.w_T_rad_s);
  if (orbit.active()) {
    const Eigen::Vector3d u = state.R_IT.transpose() * orbit.R_IH_at(state.time_s).col(0);
    torque += 3.0 * orbit.mean_motion_rad_s * orbit.mean_motion_rad_s * u.cross(inertia.J_T * u);
  }
  return inertia.J_inverse * torque;
}

bool advance(const Inertia& inertia,
             const Orbit& orbit,
             double time_s,
             RotationState& state,
             RotationDerivative* derivative) {
  // The remaining steps are counted after every step, as the rate may change.
  for (int i = 0; i < kRotationStepsMax; ++i) {
    const double left_s = time_s - state.time_s;
    const double rate_rad_s = state.w_T_rad_s.norm() + orbit.mean_motion_rad_s;
    const double steps_left = std::abs(left_s) * rate_rad_s / kRotationStepAngle_rad;
    if (!(steps_left < kRotationStepsMax) || !state.R_IT.allFinite()) {
      return false;
    }
    if (left_s == 0.0) {
      return true;
    }
    const Nodes nodes = step(inertia, orbit, left_s / (1.0 + std::floor(steps_left)), state);
    if (derivative != nullptr) {
      step_derivative(inertia, orbit, left_s / (1.0 + std::floor(steps_left)), nodes, *derivative);
    }
    state = nodes.end;
    if (steps_left < 1.0) {
      state.time_s = time_s;
    }
  }
  return false;
}

}  // namespace polhode
