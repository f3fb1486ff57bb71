#include "motion/body_dynamics.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/so3.hpp"

namespace polhode {
namespace {

// Ratios and periods, relative sigmas. Chosen: 1.96 sigma are a fifth of the value, or all of it.
constexpr double kObservedRelative = 0.1;
constexpr double kWeakRelative = 0.5;
// Directions: 6 deg and 30 deg, the same numbers in radians.
constexpr double kObservedAngle_rad = 0.1;
constexpr double kWeakAngle_rad = 0.5;

// Principal moments (largest 1) nearer to each other than this leave their axes open.
constexpr double kMomentGapMin = 1e-12;
// A rate within 4 sigma of zero is no rotation: with three components a body at rest exceeds that
// with a probability of 0.1 % (chi-square of 16, worst direction).
constexpr double kRateSigmasMin = 4.0;

using Gradient = Eigen::Matrix<double, kRotationUnknowns, 1>;

Observability classify(double sigma, double observed_max, double weak_max) {
  if (!(sigma < weak_max)) {
    return Observability::kUnobserved;
  }
  return sigma < observed_max ? Observability::kObserved : Observability::kWeak;
}

RotationCovariance turning_covariance(const RigidModel& model) {
  return model.covariance.topLeftCorner<kRotationUnknowns, kRotationUnknowns>();
}

double sigma_of(const Gradient& gradient, const RigidModel& model) {
  return std::sqrt(std::max(0.0, gradient.dot(turning_covariance(model) * gradient)));
}

struct Principal {
  Eigen::Vector3d moments;
  Eigen::Matrix3d R_TP;
};

Principal principal(const Inertia& inertia) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(inertia.J_T);
  Principal axes{.moments = eigen.eigenvalues(), .R_TP = eigen.eigenvectors()};
  for (Eigen::Index k = 0; k < 2; ++k) {
    Eigen::Index largest = 0;
    axes.R_TP.col(k).cwiseAbs().maxCoeff(&largest);
    axes.R_TP.col(k) *= axes.R_TP(largest, k) < 0.0 ? -1.0 : 1.0;
  }
  axes.R_TP.col(2) = axes.R_TP.col(0).cross(axes.R_TP.col(1));
  return axes;
}

/// Gradient of v_i^T J v_j over `divisor` by the unknowns.
Gradient moment_gradient(
    const Inertia& inertia, const Principal& axes, Eigen::Index i, Eigen::Index j, double divisor) {
  Gradient gradient = Gradient::Zero();
  for (Eigen::Index k = 0; k < 5; ++k) {
    gradient(6 + k) =
        axes.R_TP.col(i).dot(inertia.J_by_shape[static_cast<std::size_t>(k)] * axes.R_TP.col(j)) /
        divisor;
  }
  return gradient;
}

/// A number that follows from rate and shape (decision 0047). Its relative variance comes
/// from differences along the axes of their covariance, to the second order, plus the square of the
/// bias. Where two moments are nearly equal, ratios and periods bend within a sigma, and their
/// slope at the best fit may vanish. Along an axis that leaves a second moment open to a factor of
/// e the posterior is not Gaussian, and the slope is taken.
/// @source Norgaard, Poulsen, Ravn, "New developments in state estimation for nonlinear systems",
/// Automatica 2000.
template <typename Function>
Estimated of_turning(const RigidModel& model, const Function& function) {
  constexpr Eigen::Index kUnknowns = kRotationUnknowns - 3;  // without the attitude
  using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
  // The kurtosis of a Gaussian: with it the differences are right to the fourth moment.
  constexpr double kSpread2 = 3.0;
  // In the logarithm of a second moment: a factor of e.
  constexpr double kShapeStepMax = 1.0;
  // Step of the slope in the same unit. Chosen: small against the bend, large against rounding.
  constexpr double kSlopeStep = 0.05;
  const auto log_at = [&](const Unknowns& change) {
    const InertiaShape shape = model.shape + change.tail<5>();
    const Eigen::Vector3d w = model.reference.w_T_rad_s + change.head<3>();
    return std::log(function(inertia_of(shape).J_T, w));
  };
  // In units of the unknowns' own sigmas: rates are so small beside shapes that rounding would hide
  // them.
  const Eigen::Matrix<double, kUnknowns, kUnknowns> covariance =
      turning_covariance(model).bottomRightCorner<kUnknowns, kUnknowns>();
  const Unknowns own =
      covariance.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt();
  const Unknowns inverse = own.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kUnknowns, kUnknowns>> eigen(
      inverse.asDiagonal() * covariance * inverse.asDiagonal());
  const double log_value = log_at(Unknowns::Zero());
  double variance = 0.0;
  double bias = 0.0;
  for (Eigen::Index k = 0; k < kUnknowns; ++k) {
    const Unknowns sigma = std::sqrt(std::max(0.0, eigen.eigenvalues()(k))) *
                           own.cwiseProduct(eigen.eigenvectors().col(k));
    const double open = std::sqrt(kSpread2) * sigma.tail<5>().norm();
    const bool bent = open < kShapeStepMax;
    const double spread2 = bent ? kSpread2 : std::pow(kSlopeStep / sigma.tail<5>().norm(), 2);
    const double ahead = log_at(std::sqrt(spread2) * sigma) - log_value;
    const double behind = log_at(-std::sqrt(spread2) * sigma) - log_value;
    if (bent) {
      variance += std::pow(ahead - behind, 2) / (4.0 * spread2) +
                  std::pow(ahead + behind, 2) / (2.0 * spread2 * spread2);
      bias += (ahead + behind) / (2.0 * spread2);
    } else {
      // The order of nearly equal moments may change: the slopes of both directions differ.
      variance += (ahead * ahead + behind * behind) / (2.0 * spread2);
    }
  }
  const double value = std::exp(log_value);
  const double sigma = std::sqrt(variance + bias * bias);
  const bool finite = std::isfinite(value) && std::isfinite(sigma);
  return {.value = value,
          .sigma = value * sigma,
          .observability = finite ? classify(sigma, kObservedRelative, kWeakRelative)
                                  : Observability::kUnobserved};
}

void add_inertia(const RigidModel& model, const Inertia& inertia, BodyDynamics* out) {
  const Principal axes = principal(inertia);
  out->R_TP = axes.R_TP;
  const auto ratio = [&](Eigen::Index k) {
    return of_turning(model, [k](const Eigen::Matrix3d& J_T, const Eigen::Vector3d&) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(J_T, Eigen::EigenvaluesOnly);
      return eigen.eigenvalues()(k) / eigen.eigenvalues()(0);
    });
  };
  out->middle_over_least = ratio(1);
  out->largest_over_least = ratio(2);
  for (Eigen::Index k = 0; k < 3; ++k) {
    double variance = 0.0;
    for (Eigen::Index other = 0; other < 3; ++other) {
      if (other != k) {
        const double apart =
            std::max(kMomentGapMin, std::abs(axes.moments(k) - axes.moments(other)));
        variance += std::pow(sigma_of(moment_gradient(inertia, axes, k, other, apart), model), 2);
      }
    }
    const auto index = static_cast<std::size_t>(k);
    out->sigma_axis_rad[index] = std::sqrt(variance);
    out->axes[index] = classify(std::sqrt(variance), kObservedAngle_rad, kWeakAngle_rad);
  }
}

void add_momentum(const RigidModel& model, const Inertia& inertia, BodyDynamics* out) {
  const Eigen::Vector3d h_T = inertia.J_T * model.reference.w_T_rad_s;
  const double size = h_T.norm();
  if (!(size > 0.0)) {
    return;
  }
  const Eigen::Matrix3d& R = model.reference.R_IT;
  out->momentum_axis_I = R * h_T / size;
  RotationJacobian by = RotationJacobian::Zero();
  by.leftCols<3>() = -hat(R * h_T);
  by.middleCols<3>(3) = R * inertia.J_T;
  for (Eigen::Index k = 0; k < 5; ++k) {
    by.col(6 + k) = R * inertia.J_by_shape[static_cast<std::size_t>(k)] * model.reference.w_T_rad_s;
  }
  const Eigen::Matrix3d across =
      (Eigen::Matrix3d::Identity() - out->momentum_axis_I * out->momentum_axis_I.transpose()) /
      size;
  const Eigen::Matrix3d covariance =
      across * by * turning_covariance(model) * by.transpose() * across;
  out->sigma_momentum_axis_rad = worst_sigma(covariance);
  out->momentum_axis = classify(out->sigma_momentum_axis_rad, kObservedAngle_rad, kWeakAngle_rad);
}

void add_path(const RigidModel& model, BodyDynamics* out) {
  out->v_I = model.path.segment<3>(3);
  out->covariance_v_I = model.covariance.block<3, 3>(kRotationUnknowns + 3, kRotationUnknowns + 3);
  const Eigen::Matrix3d covariance = model.covariance.bottomRightCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance);
  out->mass_centre_axes_T = eigen.eigenvectors();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const double sigma = std::sqrt(std::max(0.0, eigen.eigenvalues()(k)));
    out->mass_centre[static_cast<std::size_t>(k)] = {
        .value = eigen.eigenvectors().col(k).dot(model.path.tail<3>()),
        .sigma = sigma,
        .observability = observability_of(sigma, model.mass_centre_sigma)};
  }
}

/// Complete elliptic integral of the first kind, by the arithmetic-geometric mean.
double elliptic_K(double m) {
  double a = 1.0;
  double b = std::sqrt(std::max(0.0, 1.0 - m));
  // The digits double with each step; the bound is for m next to 1.
  constexpr int kIterationsMax = 40;
  constexpr double kRounding = 1e-15;
  for (int i = 0; i < kIterationsMax && std::abs(a - b) > kRounding * a; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return 0.5 * std::numbers::pi / a;
}

/// Moments and rate in principal axes, in order of growing moment.
struct InPrincipal {
  Eigen::Vector3d J;
  Eigen::Vector3d w;
  bool about_largest;  ///< the polhode surrounds the axis of the largest moment, else of the least
};

/// Parameter m of the elliptic functions that the rate follows; 1 for rotation about the middle
/// axis.
double modulus_of(const InPrincipal& body) {
  const Eigen::Vector3d& J = body.J;
  const double momentum2 = J.cwiseProduct(body.w).squaredNorm();
  const double energy2 = J.dot(body.w.cwiseAbs2());
  const double low = momentum2 - energy2 * J(0);
  const double high = energy2 * J(2) - momentum2;
  return body.about_largest ? (J(1) - J(0)) * high / ((J(2) - J(1)) * low)
                            : (J(2) - J(1)) * low / ((J(1) - J(0)) * high);
}

InPrincipal in_principal(const Eigen::Matrix3d& J_T, const Eigen::Vector3d& w_T_rad_s) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(J_T);
  InPrincipal body{.J = eigen.eigenvalues(),
                   .w = eigen.eigenvectors().transpose() * w_T_rad_s,
                   .about_largest = false};
  const double momentum2 = body.J.cwiseProduct(body.w).squaredNorm();
  const double energy2 = body.J.dot(body.w.cwiseAbs2());
  body.about_largest = momentum2 >= energy2 * body.J(1);
  return body;
}

}  // namespace

double spin_period_s(const Eigen::Matrix3d& J_T, const Eigen::Vector3d& w_T_rad_s) {
  const InPrincipal body = in_principal(J_T, w_T_rad_s);
  const Eigen::Vector3d& J = body.J;
  const double momentum2 = J.cwiseProduct(body.w).squaredNorm();
  const double energy2 = J.dot(body.w.cwiseAbs2());
  const double product = J.prod();
  const double low = momentum2 - energy2 * J(0);
  const double high = energy2 * J(2) - momentum2;
  const double rate2 =
      body.about_largest ? (J(2) - J(1)) * low / product : (J(1) - J(0)) * high / product;
  return 4.0 * elliptic_K(std::min(1.0, modulus_of(body))) / std::sqrt(std::max(0.0, rate2));
}

double precession_period_s(const Eigen::Matrix3d& J_T, const Eigen::Vector3d& w_T_rad_s) {
  const InPrincipal body = in_principal(J_T, w_T_rad_s);
  const Eigen::Vector3d& J = body.J;
  const double momentum2 = J.cwiseProduct(body.w).squaredNorm();
  const double energy2 = J.dot(body.w.cwiseAbs2());
  const Eigen::Index axis = body.about_largest ? 2 : 0;
  const Eigen::Index other = 2 - axis;
  // Squares of the rate about the axes other than `axis` at their largest: w_other = a cn, w_1 = b
  // sn.
  const double room = std::abs(momentum2 - energy2 * J(axis));
  const double a2 = room / (J(other) * std::abs(J(2) - J(0)));
  const double b2 = room / (J(1) * std::abs(J(1) - J(axis)));
  const double m = modulus_of(body);
  if (!(m < 1.0) || !std::isfinite(a2 + b2)) {
    return std::numeric_limits<double>::infinity();
  }
  // Mean over a period, in equal steps of the amplitude, of the rate at which `axis` moves about
  // the momentum, |h| (h_1 w_1 + h_o w_o) / (h_1^2 + h_o^2). The midpoint rule converges
  // exponentially on a periodic function: exact to rounding except near m = 1.
  constexpr int kSteps = 256;
  // Momentum across the axis under a billionth of all of it, squared: rotation about the axis
  // itself.
  constexpr double kAcross2Min = 1e-18;
  double sum = 0.0;
  double time = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    const double sine = std::sin(std::numbers::pi * (i + 0.5) / kSteps);
    const double w1_2 = b2 * sine * sine;
    const double wo_2 = a2 * (1.0 - sine * sine);
    const double across2 = J(1) * J(1) * w1_2 + J(other) * J(other) * wo_2;
    const double weight = 1.0 / std::sqrt(1.0 - m * sine * sine);
    // About the axis itself: |h| over the mean of the other moments.
    sum += weight * (across2 > kAcross2Min * momentum2 ? (J(1) * w1_2 + J(other) * wo_2) / across2
                                                       : 2.0 / (J(1) + J(other)));
    time += weight;
  }
  return 2.0 * std::numbers::pi * time / (std::sqrt(momentum2) * sum);
}

Result<BodyDynamics> describe_dynamics(const RigidModel& model) {
  if (!model.accepted()) {
    return ErrorCode::kDegenerate;
  }
  const Inertia inertia = inertia_of(model.shape);
  BodyDynamics out;
  add_inertia(model, inertia, &out);
  add_momentum(model, inertia, &out);
  out.rotation_period_s = of_turning(model, [](const Eigen::Matrix3d&, const Eigen::Vector3d& w) {
    return 2.0 * std::numbers::pi / w.norm();
  });
  out.spin_period_s = of_turning(model, spin_period_s);
  out.precession_period_s = of_turning(model, precession_period_s);
  // Steady rotation about a principal axis shows neither period.
  const bool steady = out.largest_over_least.observability == Observability::kUnobserved &&
                      out.middle_over_least.observability == Observability::kUnobserved;
  if (steady) {
    out.spin_period_s.observability = Observability::kUnobserved;
    out.precession_period_s.observability = Observability::kUnobserved;
  }
  // A body that may be at rest has no axis of rotation.
  const double sigma_rate = worst_sigma(model.covariance.block<3, 3>(3, 3));
  if (!(model.reference.w_T_rad_s.norm() > kRateSigmasMin * sigma_rate)) {
    out.rotation_period_s.observability = Observability::kUnobserved;
    out.spin_period_s.observability = Observability::kUnobserved;
    out.precession_period_s.observability = Observability::kUnobserved;
    out.momentum_axis = Observability::kUnobserved;
  }
  if (model.translation_known) {
    add_path(model, &out);
  }
  return out;
}

}  // namespace polhode
