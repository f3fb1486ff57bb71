#include "motion/residual_level.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/median.hpp"
#include "config/limits.hpp"

namespace polhode {
namespace {

constexpr double kMedian3 = 2.366;  // of chi-square with three degrees of freedom
// 5 sigma, squared. With three degrees of freedom 1.5e-5 of good residuals lie beyond.
constexpr double kGate2 = 25.0;
// The declared sigma has the weight of this many numbers. Chosen: a dozen poses, of which 11
// unknowns have taken a third, carry little information on the noise.
constexpr double kDeclaredWeight = 20.0;
// Against a division by zero.
constexpr double kRotationMin_rad = 1e-9;

double median2_of(std::span<const Eigen::Vector3d> residuals) {
  std::array<double, limits::kMotionPoses> squares{};
  const std::size_t count = std::min(residuals.size(), squares.size());
  for (std::size_t i = 0; i < count; ++i) {
    squares[i] = residuals[i].squaredNorm();
  }
  return median(std::span(squares).first(count)) / kMedian3;
}

/// 1 + 2 sum of the autocorrelation over its first lags, in pairs while those are positive.
/// @source Geyer, "Practical Markov chain Monte Carlo", Statistical Science 1992 (initial positive
/// sequence).
double correlation_length(std::span<const Eigen::Vector3d> residuals, double gate2) {
  const auto kept = [&](std::size_t i) { return residuals[i].squaredNorm() <= gate2; };
  double square = 0.0;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    square += kept(i) ? residuals[i].squaredNorm() : 0.0;
  }
  if (!(square > 0.0)) {
    return 1.0;
  }
  const auto at_lag = [&](std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i + lag < residuals.size(); ++i) {
      sum += kept(i) && kept(i + lag) ? residuals[i].dot(residuals[i + lag]) : 0.0;
    }
    return sum / square;
  };
  double length = 1.0;
  // Longer lags have too few products: a third of the series at most. Chosen.
  for (std::size_t lag = 1; lag + 1 < residuals.size() / 3; lag += 2) {
    const double pair = at_lag(lag) + at_lag(lag + 1);
    // The sigma of a pair for white residuals: sqrt(2 / 3N).
    if (pair < std::sqrt(2.0 / (3.0 * static_cast<double>(residuals.size())))) {
      break;
    }
    length += 2.0 * pair;
  }
  return length;
}

}  // namespace

ResidualLevel residual_level(const ResidualInput& input) {
  ResidualLevel level;
  if (input.residuals.empty()) {
    return level;
  }
  const double gate2 = kGate2 * std::max(1.0, median2_of(input.residuals));
  double chi2 = 0.0;
  for (const Eigen::Vector3d& residual : input.residuals) {
    const double square = residual.squaredNorm();
    const bool inside = square <= gate2;  // false for NaN
    chi2 += inside ? square : 0.0;
    level.outliers += inside ? 0 : 1;
    level.outliers_at_end = inside ? 0 : level.outliers_at_end + 1;
  }
  const double count = static_cast<double>(input.residuals.size());
  const double inside = count - static_cast<double>(level.outliers);
  const double freedom = std::max(1.0, 3.0 * inside - input.unknowns);
  level.chi2_per_dof = chi2 / freedom;
  level.scale2 = (chi2 + kDeclaredWeight) / (freedom + kDeclaredWeight);
  const double of_side = poses_of_a_face(input.rotation_of_frame_rad, input.residuals.size());
  const double by_drift = 1.0 + input.drift_share * (of_side - 1.0);
  level.correlation = std::max(by_drift, correlation_length(input.residuals, gate2));
  return level;
}

double poses_of_a_face(double rotation_of_frame_rad, std::size_t poses) {
  return std::clamp(2.0 * kFaceAngle_rad / std::max(kRotationMin_rad, rotation_of_frame_rad),
                    1.0,
                    std::max(1.0, 0.5 * static_cast<double>(poses)));
}

double widening(const ResidualLevel& level) { return level.scale2 * level.correlation; }

}  // namespace polhode
