// Nonlinear least squares in a few unknowns, by Ceres's TinySolver, without heap.
//
// TinySolver takes residuals r and their Jacobian J, and uses them only in J^T J, J^T r and r^T r.
// A fit of a thousand residuals therefore passes its normal equations, as a square root: N + 1
// residuals that have the same three products. Its steps are those of all residuals, to rounding.
// A robust loss passes its own equations (weights in H and g, the loss in the cost), as Ceres does.
#pragma once

#include <ceres/tiny_solver.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/so3.hpp"

namespace polhode {

/// Normal equations and cost of a fit at one place. A fit derives its own from this, with more
/// results.
template <int N>
struct SmallEquations {
  static constexpr int kUnknowns = N;
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  Matrix H = Matrix::Zero();  ///< sum of w J^T J; w: derivative of the loss by the squared residual
  Vector g = Vector::Zero();  ///< sum of w J^T r, r = model - measured
  double cost = 0.0;          ///< sum of the losses; of r^T r without a loss
};

enum class FirstThree {
  kPlain,
  /// Unknowns 0 to 2 are phi in R = exp(phi) R_start. Equations are by a further rotation d,
  /// exp(d) R.
  kRotation,
};

struct SmallFitOptions {
  int steps_max = 10;           ///< a bound: it ends when the cost has settled
  double damping_first = 1e-4;  ///< smaller with better initial values
  FirstThree first_three = FirstThree::kPlain;
};

namespace small_fit {

/// Least relative gain of a step. With n degrees of freedom it moves an unknown by at most 1e-4
/// sqrt(n) of its sigma by the noise as found.
inline constexpr double kSettled = 1e-8;

/// The interface of TinySolver. Each place is linearised once: an accepted step needs the equations
/// of its trial again.
template <class Equations, class Linearise>
class Residuals {
 public:
  using Scalar = double;
  // TinySolver's names.
  // NOLINTNEXTLINE(readability-identifier-naming)
  enum { NUM_PARAMETERS = Equations::kUnknowns, NUM_RESIDUALS = NUM_PARAMETERS + 1 };
  using Vector = typename Equations::Vector;

  struct Place {
    Vector x = Vector::Zero();
    Equations equations;
  };

  Residuals(const Linearise& linearise, const SmallFitOptions& options, Place* last)
      : linearise_(linearise), options_(options), last_(last) {}

  /// TinySolver calls this without Jacobian for a trial, and with it at the initial value and at
  /// the last trial, which is accepted.
  bool operator()(const double* x, double* residuals, double* jacobian) const {
    Eigen::Map<Eigen::Matrix<double, NUM_RESIDUALS, 1>> r(residuals);
    if (jacobian != nullptr) {
      square_root(r, Eigen::Map<Eigen::Matrix<double, NUM_RESIDUALS, NUM_PARAMETERS>>(jacobian));
      return true;
    }
    last_->x = Eigen::Map<const Vector>(x);
    // TinySolver ignores what is returned for a trial: an infinite cost rejects it.
    const bool usable = last_->x.allFinite() && linearise_(last_->x, &last_->equations);
    r.setZero();
    r(NUM_PARAMETERS) = usable && std::isfinite(last_->equations.cost)
                            ? std::sqrt(last_->equations.cost)
                            : std::numeric_limits<double>::infinity();
    return true;
  }

 private:
  /// With P H P^T = L D L^T: J = (sqrt(D) L^T P; 0) and r = (J^-T g; the rest of the cost). The
  /// rest is not negative: a loss of e is at least e times its weight.
  template <class R, class J>
  void square_root(R r, J jacobian) const {
    typename Equations::Matrix H = last_->equations.H;
    Vector g = last_->equations.g;
    if constexpr (NUM_PARAMETERS >= 3) {
      if (options_.first_three == FirstThree::kRotation) {
        by_rotation_vector(&H, &g);
      }
    }
    const Eigen::LDLT<typename Equations::Matrix> ldlt(H);
    const Vector root = ldlt.vectorD().cwiseMax(0.0).cwiseSqrt();
    typename Equations::Matrix upper = Equations::Matrix::Identity();
    upper = ldlt.transpositionsP() * upper;
    upper = ldlt.matrixU() * upper;
    jacobian.template topRows<NUM_PARAMETERS>() = root.asDiagonal() * upper;
    jacobian.row(NUM_PARAMETERS).setZero();
    Vector top = ldlt.transpositionsP() * g;
    ldlt.matrixL().solveInPlace(top);
    top = (root.array() > 0.0).select(top.cwiseQuotient(root), 0.0);
    // The squared norm is the predicted gain of an undamped step. Without a gradient TinySolver
    // ends.
    if (!(top.squaredNorm() > kSettled * last_->equations.cost)) {
      top.setZero();
    }
    r.template head<NUM_PARAMETERS>() = top;
    r(NUM_PARAMETERS) = std::sqrt(std::max(0.0, last_->equations.cost - top.squaredNorm()));
  }

  /// exp(phi + d) = exp(J_l d) exp(phi) to first order.
  void by_rotation_vector(typename Equations::Matrix* H, Vector* g) const {
    const Eigen::Matrix3d J_l = so3_left_jacobian(last_->x.template head<3>());
    H->template topRows<3>() = (J_l.transpose() * H->template topRows<3>()).eval();
    H->template leftCols<3>() = (H->template leftCols<3>() * J_l).eval();
    g->template head<3>() = (J_l.transpose() * g->template head<3>()).eval();
  }

  const Linearise& linearise_;
  const SmallFitOptions& options_;
  Place* last_;
};

}  // namespace small_fit

/// Levenberg-Marquardt from `x`, which never gets worse.
/// @param linearise  bool(const Vector& x, Equations* at), Equations derived from SmallEquations;
/// false where the model is not defined: no step ends there.
/// @param x          in: initial value; out: minimum. Zero at first where the first three rotate.
/// @param at         out: the equations at the minimum.
/// @return steps tried, or -1 where the initial value is not usable.
/// @cost   a call of `linearise` for each step, one for the initial value, one where the last step
/// failed. No heap.
/// @source Madsen, Nielsen and Tingleff, IMM 2004, via Ceres.
template <class Equations, class Linearise>
int minimise(const Linearise& linearise,
             const SmallFitOptions& options,
             typename Equations::Vector* x,
             Equations* at) {
  using Residuals = small_fit::Residuals<Equations, Linearise>;
  typename Residuals::Place last{.x = *x, .equations = {}};
  if (!linearise(*x, &last.equations) || !std::isfinite(last.equations.cost) ||
      !last.equations.H.allFinite()) {
    return -1;
  }
  ceres::TinySolver<Residuals> solver;
  solver.options.max_num_iterations = options.steps_max + 1;
  // Absolute: ends steps that fail by rounding; the gradient ends the others.
  solver.options.function_tolerance = small_fit::kSettled * last.equations.cost;
  // Only for a gradient set to zero; other limits do not apply to our scales.
  solver.options.gradient_tolerance = std::numeric_limits<double>::min();
  solver.options.parameter_tolerance = 0.0;
  solver.options.cost_threshold = 0.0;
  solver.options.initial_trust_region_radius = 1.0 / options.damping_first;
  const Residuals residuals(linearise, options, &last);
  const int steps = std::min(solver.Solve(residuals, x).iterations, options.steps_max);
  if (last.x != *x) {
    linearise(*x, &last.equations);  // the last trial was rejected
  }
  *at = last.equations;
  return steps;
}

}  // namespace polhode
