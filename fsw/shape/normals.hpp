// Direction of the surface at each point of a cloud, from its neighbours.
#pragma once

#include <Eigen/Core>
#include <span>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "shape/cloud.hpp"

namespace polhode {

struct SurfaceNormal {
  Eigen::Vector3d normal_T = Eigen::Vector3d::Zero();  ///< unit, either sign
  bool reliable =
      false;  ///< the neighbours lie in a plane; false at edges, in thin or noisy places
};

using SurfaceNormals = FixedVector<SurfaceNormal, limits::kCloudPoints>;

/// Normals by the principal axes of the points within `radius`.
/// @return the surface's thickness: median over the points of the neighbours' root mean square
/// distance from their plane.
/// @cost O(N log N), and the points within the radius of each point.
double estimate_normals(std::span<const Eigen::Vector3d> points_T,
                        double radius,
                        CloudScratch& scratch,
                        SurfaceNormals& normals);

/// As above, with the smallest radius that shows a flat piece of surface: three spacings, or more
/// where the noise is large.
/// @return the thickness, about the 1-sigma noise across the surface.
double estimate_normals_by_spacing(std::span<const Eigen::Vector3d> points_T,
                                   double spacing,
                                   CloudScratch& scratch,
                                   SurfaceNormals& normals);

}  // namespace polhode
