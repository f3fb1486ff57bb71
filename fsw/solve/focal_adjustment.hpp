// The focal length that a bundle's images speak for.
#pragma once

#include "solve/bundle_problem.hpp"

namespace polhode {

struct FocalReport {
  bool usable = false;
  double factor = 1.0;           ///< of the focal length that the images were normalised with
  double relative_sigma = 0.0;   ///< 1-sigma of the factor, as a part of it
  double cost_as_given = 0.0;    ///< half the robust sum of squares with the given focal length,
  double cost_at_factor = 0.0;   ///< and with this one, both after an adjustment
  std::size_t observations = 0;  ///< that were adjusted
};

/// Adjusts copies of poses and points together with one focal length, by Ceres. The undistorted
/// picture counts as a pinhole's: normalised = factor * projection. Priors are left out.
///
/// The sigma is from how the least cost rises when the focal length is held beside the best one.
/// Residuals along a track are alike, so each counts as several times itself (decision 0085). A map
/// that was made with another focal length holds the result back: it then lies between the two.
/// @param options  observations_max bounds the work
FocalReport adjust_focal(const BundleProblem& problem, const BundleOptions& options);

/// Is the given focal length refuted? Beyond what the sigma, a bent map or a lens whose distortion
/// is left out explain.
[[nodiscard]] bool refutes_focal(const FocalReport& found);

/// Would a focal length that is off by what refutes one have been found? Else nothing is decided.
[[nodiscard]] bool bears_focal_out(const FocalReport& found);

/// By what part of itself a refuted focal length is off at least, 0 where it is not refuted. A
/// range is off by the same part: an image tells size over range, times the focal length. So is the
/// perspective of a body of radius r at distance d. That moves image points by r / d of their
/// offsets, as a turn by r / d does, so attitudes are off by up to that part of r / d.
[[nodiscard]] double part_off(const FocalReport& found);

}  // namespace polhode
