// Metres per map unit: from a known length between two image points, or from the reading of a range
// finder.
#pragma once

#include <Eigen/Core>

#include "base/result.hpp"
#include "shape/surface_hit.hpp"

namespace polhode {

// Least length in its sigmas: from 5 on. With a relative sigma of a fifth the logarithm, in which
// readings are combined, is 2 % off at the second order.
inline constexpr double kLengthSigmasMin = 5.0;

struct ScaleEstimate {
  double metres_per_mu = 0.0;
  double sigma = 0.0;  ///< 1-sigma of metres_per_mu
};

/// Scale from a known length between two points on the surface.
/// @param end_a, end_b  normalised image points of the two ends.
/// @param sigma_ray     1-sigma of a picked point, normalised units (1 px over the focal length,
/// when picked by hand). It may put an end at an edge onto the surface beside it; the result's
/// sigma includes that.
/// @errors those of hit_surface(); BadParameter (known_length_m not positive), Degenerate (the
/// length is under kLengthSigmasMin of its sigmas).
Result<ScaleEstimate> scale_from_length(const ScaleView& view,
                                        const Eigen::Vector2d& end_a,
                                        const Eigen::Vector2d& end_b,
                                        double known_length_m,
                                        double sigma_ray);

/// Scale from the distance along the boresight to the nearest surface.
/// @param sigma_range_m  1-sigma of the reading, >= 0.
/// @errors those of hit_surface(); BadParameter (range_m not positive).
Result<ScaleEstimate> scale_from_range(const ScaleView& view, double range_m, double sigma_range_m);

}  // namespace polhode
