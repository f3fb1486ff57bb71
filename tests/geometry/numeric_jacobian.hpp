// Derivatives by central differences, for comparison with analytic ones.
#pragma once

#include <Eigen/Core>

namespace polhode {

/// d f / d x at x = 0 of f: R^kIn -> R^kOut. With a step of 1e-5 the error is about 1e-10 of the
/// third derivative plus 1e-11 of rounding.
template <int kOut, int kIn, typename Function>
Eigen::Matrix<double, kOut, kIn> numeric_jacobian(const Function& f) {
  constexpr double kStep = 1e-5;
  Eigen::Matrix<double, kOut, kIn> J;
  for (int k = 0; k < kIn; ++k) {
    Eigen::Matrix<double, kIn, 1> step = Eigen::Matrix<double, kIn, 1>::Zero();
    step(k) = kStep;
    J.col(k) = (f(step) - f(Eigen::Matrix<double, kIn, 1>(-step))) / (2.0 * kStep);
  }
  return J;
}

}  // namespace polhode
