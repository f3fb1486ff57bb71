// Covariance of a least-squares fit whose residuals are correlated over patches. A bent map or a
// dent is off by the same amount over a patch, so white noise would give too narrow sigmas.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "base/assert.hpp"

namespace polhode {

/// Sums of the gradient over each patch of a surface. Each patch counts as one observation.
/// @source Liang and Zeger, "Longitudinal data analysis using generalized linear models", 1986.
template <int kUnknowns, std::size_t kGroups>
class GroupedCovariance {
 public:
  using Vector = Eigen::Matrix<double, kUnknowns, 1>;
  using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

  /// @param gradient  weight * residual * derivative of the residual by the unknowns.
  void add(std::size_t group, const Vector& gradient) {
    POLHODE_ASSERT(group < kGroups, group);
    sums_[group] += gradient;
    used_[group] = true;
  }

  /// @param information  sum of weight * derivative * derivative^T, invertible.
  /// @return covariance of the unknowns; zero where fewer patches are filled than unknowns and two
  /// more.
  [[nodiscard]] Matrix covariance(const Matrix& information) const {
    Matrix scatter = Matrix::Zero();
    int count = 0;
    for (std::size_t g = 0; g < kGroups; ++g) {
      if (used_[g]) {
        scatter += sums_[g] * sums_[g].transpose();
        ++count;
      }
    }
    if (count < kUnknowns + 2) {
      return Matrix::Zero();
    }
    const Matrix inverse = information.ldlt().solve(Matrix::Identity());
    const double left = static_cast<double>(count) / (count - 1);
    return left * inverse * scatter * inverse;
  }

 private:
  std::array<Vector, kGroups> sums_ = [] {
    std::array<Vector, kGroups> zero;
    zero.fill(Vector::Zero());
    return zero;
  }();
  std::array<bool, kGroups> used_{};
};

/// `covariance`, scaled up for each unknown whose variance in `floor` is larger. Unknowns may
/// differ in unit.
template <typename Matrix>
[[nodiscard]] Matrix not_below(const Matrix& floor, const Matrix& covariance) {
  if (!(covariance.diagonal().array() > 0.0).all()) {  // true for NaN as well
    return floor;
  }
  const auto wider =
      floor.diagonal().cwiseQuotient(covariance.diagonal()).cwiseMax(1.0).cwiseSqrt().eval();
  return wider.asDiagonal() * covariance * wider.asDiagonal();
}

}  // namespace polhode
