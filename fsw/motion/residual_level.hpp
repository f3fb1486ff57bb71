// The noise by the residuals: how large it is, and how much of it poses share.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "motion/model.hpp"

namespace polhode {

/// Poses of one visible face share their errors: on rendered sequences the correlation falls to 1/e
/// over 45 to 55 deg of rotation (decision 0051).
inline constexpr double kFaceAngle_rad = 0.8;

/// Number of poses that are worth one independent pose, of `poses` that rotate by
/// `rotation_of_frame_rad` from one to the next: the sum of that correlation over all of them.
[[nodiscard]] double poses_of_a_face(double rotation_of_frame_rad, std::size_t poses);

struct ResidualInput {
  std::span<const Eigen::Vector3d> residuals;  ///< in order of time, in sigmas as declared
  int unknowns = 0;                            ///< that were fitted
  /// Part of the declared variance that is an error of the map: poses of one visible face share it.
  double drift_share = 0.0;
  double rotation_of_frame_rad = 0.0;  ///< mean angle between successive poses
};

/// @see ResidualLevel. Outliers are residuals over 5 sigma, by the declared or the found noise,
/// whichever is larger.
ResidualLevel residual_level(const ResidualInput& input);

/// Factor on the covariance of a fit that took residuals as independent and of the declared size.
[[nodiscard]] double widening(const ResidualLevel& level);

}  // namespace polhode
