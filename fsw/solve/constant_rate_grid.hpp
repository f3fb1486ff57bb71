// A distant body with a constant rate of rotation: search over rates, with the shape solved for.
#pragma once

#include <Eigen/Core>
#include <span>

#include "base/fixed_vector.hpp"
#include "solve/affine_factorisation.hpp"

namespace polhode {

struct ConstantRateMotion {
  Eigen::Vector3d w_C_rad_s =
      Eigen::Vector3d::Zero();  ///< in the camera's axes, about the middle of the interval
  double scale_rate_1_s = 0.0;  ///< relative change of the image scale
  double residual2 = 0.0;       ///< sum of squares outside the model, normalised units
};

// Minima that are kept. Chosen: each costs two adjustments, one for its depth-reversed solution.
inline constexpr std::size_t kConstantRateMotions = 4;
using ConstantRateMotions = FixedVector<ConstantRateMotion, kConstantRateMotions>;

/// Different local minima of the residual, best first. The depth-reversed solution of each, (-wx,
/// -wy, wz), has the same residual and is left out.
/// @param images   2 F x N, less the centroids (see `centred`), inliers only.
/// @param times_s  F, ascending; F >= 3.
/// @cost 12 azimuths x 7 rotations, at most 8 steps in four dimensions each.
ConstantRateMotions search_constant_rate(const ImageMatrix& images,
                                         std::span<const double> times_s);

/// Rotations and scales of the frames.
WeakPerspectiveMotion to_motion(const ConstantRateMotion& rate, std::span<const double> times_s);

}  // namespace polhode
