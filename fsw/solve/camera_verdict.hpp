// Decides which deviations of a camera are significant, and gives their effect on poses.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "geometry/camera_model.hpp"
#include "geometry/pose.hpp"
#include "solve/camera_adjustment.hpp"

namespace polhode {

/// Result of a test of the stated camera.
struct CameraFinding {
  std::array<std::uint8_t, kDeviations> contradicted{};  ///< 1: the stated value is contradicted
  /// The fewest deviations that explain the images, fitted together; each other one fitted in
  /// addition.
  Deviations value = Deviations::Zero();
  Deviations sigma = Deviations::Zero();
  ImageRates rates;  ///< for the effect of the times of rows and halves

  [[nodiscard]] bool any() const;
  [[nodiscard]] bool is(Deviation deviation) const {
    return contradicted[static_cast<std::size_t>(deviation)] != 0;
  }
  [[nodiscard]] double of(Deviation deviation) const {
    return value[static_cast<Eigen::Index>(deviation)];
  }
  [[nodiscard]] double sigma_of(Deviation deviation) const {
    return sigma[static_cast<Eigen::Index>(deviation)];
  }
};

/// Finds the significant deviations by backward elimination: insignificant ones, under four sigma,
/// are fixed one by one. A focal length or zoom counts from 8 % on: with a right camera it is off
/// by up to 1.9 % where the sigma is under 2 %, and by more in a bent map (decision 0083).
CameraFinding find_deviations(const CameraFit& fit);

/// Joins the findings of an earlier and a later test. A later one with any contradiction replaces
/// the earlier: its deviations explain the images together. Else a contradiction stays until a test
/// that could have found it does not.
CameraFinding joined(const CameraFinding& earlier, const CameraFinding& later);

/// Are all numbers in the range of a test's results? Not where memory was damaged.
[[nodiscard]] bool is_valid(const CameraFinding& found);

/// A deviation as text.
struct DeviationText {
  std::string_view name;  ///< with its unit
  double stated = 0.0;
  double fits = 0.0;
  double sigma = 0.0;  ///< of the fitted value
};
DeviationText describe(Deviation deviation, const CameraFinding& found, const CameraModel& stated);

/// 1-sigma that contradicted deviations add to a pose, as nothing is corrected.
struct CameraError {
  double attitude_rad = 0.0;  ///< about each axis
  double across = 0.0;        ///< of a position across the line of sight, as a part of the range
  double along = 0.0;         ///< the same along the line of sight; of lengths and velocities, too
};

/// @param size  radius of the body over its range
CameraError error_by(const CameraFinding& found, double size);

/// Adds a camera's error to a pose. Its effect on lengths is in the error of their unit.
/// @param range  of the pose, in its unit
void widen(const CameraError& error, double range, PoseCovariance* covariance);

}  // namespace polhode
