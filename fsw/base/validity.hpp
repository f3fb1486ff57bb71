// Tests of values that may have been changed from outside: read from a file, or hit by a bit flip.
// A value is valid when the rest of the program may compute with it.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace polhode::validity {

/// No number of a component is larger: products of a few of them stay finite.
inline constexpr double kMagnitudeMax = 1e12;
/// Error of R R^T. Rotations are kept to rounding, 1e-12 after a long run.
inline constexpr double kRotationError = 1e-6;
/// 30 years. Times farther apart are not of one run, and their differences may overflow.
inline constexpr std::int64_t kTimeMax_ns = 946'080'000'000'000'000;

/// Before the year 2116: the difference of two such times, of either sign, is a number.
inline bool is_time(std::int64_t ns) { return ns > INT64_MIN / 2 && ns < INT64_MAX / 2; }

/// A bool is one byte, which is 0 or 1.
inline bool is_bool(const bool& value) {
  std::uint8_t byte = 0;
  std::memcpy(&byte, &value, sizeof byte);
  return byte <= 1;
}

/// Restores a flag of which a bit other than the lowest has flipped: the lowest bit is its value.
/// @return whether it was repaired.
inline bool repair(bool* value) {
  std::uint8_t byte = 0;
  std::memcpy(&byte, value, sizeof byte);
  if (byte <= 1) {
    return false;
  }
  byte &= 1U;
  std::memcpy(value, &byte, sizeof byte);
  return true;
}

/// Is the value an enumerator? For an Enum that is numbered from 0 to `last` without gaps.
template <typename Enum>
bool is_enum(Enum value, Enum last) {
  using Number = std::underlying_type_t<Enum>;
  return static_cast<Number>(value) >= 0 && static_cast<Number>(value) <= static_cast<Number>(last);
}

inline bool is_bounded(double value) { return std::abs(value) <= kMagnitudeMax; }

template <typename Derived>
bool is_bounded(const Eigen::MatrixBase<Derived>& values) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (!is_bounded(static_cast<double>(values(i % values.rows(), i / values.rows())))) {
      return false;
    }
  }
  return true;
}

/// Finite, bounded and not under `least`.
inline bool is_at_least(double value, double least) { return value >= least && is_bounded(value); }

inline bool is_rotation(const Eigen::Matrix3d& R) {
  return is_bounded(R) && R.determinant() > 0.0 &&
         (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < kRotationError;
}

inline bool is_unit(const Eigen::Vector3d& v) {
  return is_bounded(v) && std::abs(v.norm() - 1.0) < kRotationError;
}

/// Bounded and without a negative variance.
template <typename Derived>
bool is_covariance(const Eigen::MatrixBase<Derived>& C) {
  return is_bounded(C) && C.diagonal().minCoeff() >= 0.0;
}

inline bool is_positive_definite(const Eigen::Matrix3d& C) {
  return is_bounded(C) && C.llt().info() == Eigen::Success;
}

/// Before `now_ns` or at it, by no more than a run lasts.
inline bool is_past(std::int64_t time_ns, std::int64_t now_ns) {
  return time_ns <= now_ns &&
         static_cast<std::uint64_t>(now_ns) - static_cast<std::uint64_t>(time_ns) <=
             static_cast<std::uint64_t>(kTimeMax_ns);
}

}  // namespace polhode::validity
