// Cauchy's loss of a squared residual e: width^2 log(1 + e / width^2).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace polhode {

inline double cauchy_loss(double error2, double width) {
  const double width2 = width * width;
  return width2 * std::log1p(error2 / width2);
}

/// Derivative of the loss by the squared residual.
inline double cauchy_weight(double error2, double width) {
  return 1.0 / (1.0 + error2 / (width * width));
}

/// A residual whose square is the loss of another, and its derivative by that one.
struct CauchyResidual {
  Eigen::Vector2d value;
  /// Gives the loss's gradient exactly. Across the residual, where a square does not depend on it,
  /// the curvature is that of re-weighting; along it, it is less, as the loss flattens.
  Eigen::Matrix2d by_residual;
};

inline CauchyResidual cauchy_residual(const Eigen::Vector2d& residual, double width) {
  // Of a residual, squared: below, the loss is the square itself to all digits.
  constexpr double kSmall = 1e-12;
  const double error2 = std::max(kSmall, residual.squaredNorm());
  const double ratio = std::sqrt(cauchy_loss(error2, width) / error2);
  const double weight = cauchy_weight(error2, width);
  const double across = std::sqrt(weight);
  const double along = weight / ratio;
  return {.value = ratio * residual,
          .by_residual = across * Eigen::Matrix2d::Identity() +
                         ((along - across) / error2) * residual * residual.transpose()};
}

/// Sum of the losses of many residuals, by one logarithm of their product for many.
class CauchySum {
 public:
  explicit CauchySum(double width) : width2_(width * width), inverse_width2_(1.0 / width2_) {}

  void add(double error2) {
    product_ *= 1.0 + error2 * inverse_width2_;
    if (product_ > kLarge) {
      logs_ += std::log(product_);
      product_ = 1.0;
    }
  }
  [[nodiscard]] double value() const { return width2_ * (logs_ + std::log(product_)); }

 private:
  static constexpr double kLarge = 1e150;  // half a double's exponents: no overflow by one factor
  double width2_;
  double inverse_width2_;
  double logs_ = 0.0;
  double product_ = 1.0;
};

}  // namespace polhode
