// Metres per map unit: from a known length between two image points, or from the reading of a range
// finder.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>

#include "base/result.hpp"
#include "geometry/pose.hpp"

namespace polhode {

// A length counts from 5 of its sigmas on. A fifth as relative sigma leaves its logarithm, in which
// readings are combined, 2 % off at the second order.
inline constexpr double kLengthSigmasMin = 5.0;

struct ScaleEstimate {
  double metres_per_mu = 0.0;
  double sigma = 0.0;  ///< 1-sigma of metres_per_mu
};

/// Where a ray of the named frame meets the target.
struct SurfaceHit {
  double depth_mu = 0.0;  ///< z in C
  double sigma_mu = 0.0;  ///< 1-sigma along the ray
  Eigen::Vector3d p_C = Eigen::Vector3d::Zero();
};

/// A frame's pose and the landmarks seen in it. Only those: hidden sides have landmarks on the same
/// rays. Map units.
struct ScaleView {
  Pose pose;
  std::span<const Eigen::Vector3d> landmarks_T;
};

/// Depth of the surface on a ray, from the landmarks nearest to it in the image. The inverse depth
/// of a plane in space is linear in the image. Planes through triples of the nearest landmarks
/// compete. They must face the camera and hold landmarks next to the ray. The nearest one with
/// enough support is refined by least squares, with weights that fall with the distance from the
/// ray. Without such a plane: the nearest landmark's depth, with a wide sigma.
/// @param ray  normalised image point (undistorted).
/// @errors TooFewObservations (under 3 landmarks in front of the camera), Degenerate (the ray
/// passes the target: no
///         landmark near it in the image).
/// @cost   O(landmarks).
Result<SurfaceHit> hit_surface(const ScaleView& view, const Eigen::Vector2d& ray);

/// Scale from a known length between two points that lie on the surface.
/// @param end_a, end_b  normalised image points of the two ends.
/// @param sigma_ray     1-sigma of a picked point, normalised units (1 px over the focal length,
/// when picked by hand).
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
