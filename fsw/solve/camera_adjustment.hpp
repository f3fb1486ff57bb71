// Test of the stated camera: bundle adjustment with the camera's deviations as unknowns.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>

#include "solve/bundle_problem.hpp"

namespace polhode {

/// Deviations of a camera from the stated one, one number each; 0: none.
enum class Deviation : std::uint8_t {
  kFocal,       ///< log of true over stated focal length
  kZoom,        ///< log of the focal length at the last pose over that at the first
  kAspect,      ///< log of true over stated fv / fu
  kPrincipalU,  ///< true minus stated principal point to the right, as a part of the focal length,
  kPrincipalV,  ///< and down
  kReadout,     ///< time to read all rows [s]; negative: from the last row up
  kHalf,        ///< age of the upper half of an image less that of the lower [s]
};
// Number of the names above.
inline constexpr std::size_t kDeviations = 7;
using Deviations = Eigen::Matrix<double, kDeviations, 1>;
using DeviationInformation = Eigen::Matrix<double, kDeviations, kDeviations>;

/// Motion of a pose's image: the input for the deviations of row times and of zoom.
struct PoseMotion {
  Eigen::Matrix<double, 6, 1> rates = Eigen::Matrix<double, 6, 1>::Zero();  ///< of (phi, uvs) by s
  double phase = 0.0;  ///< -0.5 at the first pose's time, 0.5 at the last one's
};

/// Speed of the images, root mean square over the poses.
struct ImageRates {
  double turn_rad_s = 0.0;  ///< of attitudes, in the camera's axes
  double shift_s = 0.0;  ///< of T's origin across the line of sight, as a part of the range [1/s]
};

struct CameraProblem {
  BundleProblem bundle;
  std::span<const PoseMotion> motions;  ///< of each pose
  double middle_normalised = 0.0;       ///< middle of the rows,
  double height_normalised = 1.0;       ///< and height of all rows, over the focal length
  double interval_s = 1.0;              ///< shortest between two poses
};

struct CameraFit {
  bool usable = false;
  Deviations value = Deviations::Zero();  ///< all of them free
  /// Of the deviations, poses and points free, with the prior of cameras. Residuals along a track
  /// are correlated, so each counts less (decision 0085).
  DeviationInformation information = DeviationInformation::Zero();
  double gain = 0.0;  ///< fall of chi-square, with residuals weighted likewise
  ImageRates rates;
  double cost_as_given = 0.0;    ///< half the robust sum of squares with the camera as stated,
  double cost_as_found = 0.0;    ///< and with the values, both after an adjustment
  std::size_t observations = 0;  ///< that were adjusted
};

/// Adjusts copies of poses and points together with all deviations, by Ceres. The undistorted image
/// counts as a pinhole's. Priors of poses are left out. A map that was made with the stated camera
/// biases the result towards it.
/// The heap is within adjustment_bytes_max, as the bundle's is.
/// @param options  observations_max bounds the work
CameraFit adjust_camera(const CameraProblem& problem, const BundleOptions& options);

}  // namespace polhode
