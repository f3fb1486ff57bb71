// Cauchy's loss of a squared residual e: width^2 log(1 + e / width^2).
#pragma once

#include <cmath>

namespace polhode {

/// Derivative of the loss by the squared residual.
inline double cauchy_weight(double error2, double width) {
  return 1.0 / (1.0 + error2 / (width * width));
}

/// Sum of the losses of many residuals, with one logarithm for the product of many.
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
  static constexpr double kLarge = 1e150;  // half of a double's exponents: one more factor does not
                                           // overflow
  double width2_;
  double inverse_width2_;
  double logs_ = 0.0;
  double product_ = 1.0;
};

}  // namespace polhode
