// Poses and rates as they are published: in the unit of the bus, with sigmas of the worst axis.
#pragma once

#include <array>
#include <cstddef>

#include "motion/motion_state.hpp"
#include "motion/rates.hpp"

namespace polhode {

/// Writes a pose with its sigmas into a motion state; of the two quaternions of one rotation the
/// one nearer to `q_last`, which becomes the one written.
void fill_pose(const Pose& pose,
               const PoseCovariance& covariance,
               std::array<double, 4>* q_last,
               MotionState* motion);

/// Writes rates with their sigmas and covariances.
/// @param unit          of published lengths, per unit of the poses.
/// @param length_sigma  1-sigma of that unit, as a part of it.
void fill_rates(RateEstimate rates, double unit, double length_sigma, MotionState* motion);

/// Rows of the upper triangle, one after the other.
template <std::size_t kCount, typename Matrix>
std::array<double, kCount> upper_triangle(const Matrix& m) {
  std::array<double, kCount> out{};
  std::size_t i = 0;
  for (Eigen::Index row = 0; row < m.rows(); ++row) {
    for (Eigen::Index column = row; column < m.cols(); ++column) {
      out[i++] = m(row, column);
    }
  }
  return out;
}

/// The same pose with lengths multiplied by `unit`.
Pose scaled(const Pose& pose, double unit);
PoseCovariance scaled(const PoseCovariance& covariance, double unit);

/// Covariance of a length by the scale's own error, in its unit.
/// @param scale_sigma  1-sigma of the scale, as a part of it.
Eigen::Matrix3d by_scale(const Eigen::Vector3d& length, double scale_sigma);
PoseCovariance by_scale(const Pose& pose, double scale_sigma);

}  // namespace polhode
