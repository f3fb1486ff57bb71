// Bodies made of points on opaque surfaces.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/rng.hpp"

namespace polhode::synthetic {

/// B: body axes, origin at the middle of the body, metres.
struct SurfacePoint {
  Eigen::Vector3d p_B = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal_B = Eigen::Vector3d::UnitZ();  ///< outwards, unit
};
using Body = std::vector<SurfacePoint>;

/// Points spread evenly over the surface.
Body cylinder(int points,
              double radius_m,
              double height_m,
              Rng* rng);  ///< axis z, both ends closed
Body box(int points, const Eigen::Vector3d& size_m, Rng* rng);
Body sphere(int points, double radius_m, Rng* rng);
Body panel(int points,
           double width_m,
           double height_m,
           Rng* rng);  ///< in the plane z = 0, both sides
/// Inside of a paraboloid that opens towards +z: the convexity cue's enemy.
Body dish(int points, double radius_m, double depth_m, Rng* rng);
/// A box with a panel on each side along x.
Body satellite(int points, Rng* rng);

/// Largest distance of a point from the origin.
double radius_m(const Body& body);

}  // namespace polhode::synthetic
