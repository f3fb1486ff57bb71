// Value or derivative of a noisy 3-vector series at one time, from the polynomial that fits the longest stretch around it.
//
// A polynomial of degree 1, 2 or 3 is fitted by weighted least squares to the nearest 2, 3, 4, 6, 8, 12, ... points. Few
// points leave noise, many points leave what the polynomial cannot follow. Of all degrees and stretches the one with the
// least variance at the target is taken, where a stretch has to fit: its chi-square must not stand out from the common
// noise level, and one more degree must not explain significantly more (an F test: more sensitive to bend than chi-square
// over the whole stretch). What misfit remains widens the covariance.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>

#include "base/result.hpp"

namespace polhode {

struct SeriesPoint {
  double tau_s = 0.0;  ///< time relative to the series' reference
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  ///< inverse covariance, positive definite
};

struct LocalTarget {
  double tau_s = 0.0;
  int derivative = 0;  ///< 0: the value; 1: its rate per second
};

inline constexpr int kLocalDegreeMax = 3;

struct LocalFit {
  Eigen::Vector3d estimate = Eigen::Vector3d::Zero();  ///< at the target
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the estimate, misfit included
  std::array<Eigen::Vector3d, kLocalDegreeMax + 1> coefficients{};  ///< of tau^k, per second^k; 0 above `degree`
  int degree = 0;
  std::size_t points = 0;      ///< nearest points used
  double span_s = 0.0;         ///< largest |tau| among them
  double chi2 = 0.0;
  int degrees_of_freedom = 0;  ///< 3 (points - degree - 1); 0 means that nothing has tested the model
  double misfit = 1.0;         ///< factor by which the covariance was widened, >= 1
};

/// @param points  ordered so that each prefix is a stretch to be tried: nearest to the target first.
/// @errors TooFewObservations (under 2 points), Degenerate (times coincide, or an information matrix is not usable).
/// @cost   one pass over the points, then at most 3 systems of 15 unknowns for each of at most 17 stretches.
Result<LocalFit> fit_local(std::span<const SeriesPoint> points, const LocalTarget& target);

}  // namespace polhode
