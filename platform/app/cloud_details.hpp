// Details of each point of a cloud: the surface's direction there, its sigma, and its number of
// views.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/smooth.hpp"
#include "shape/shape.hpp"

namespace polhode::platform {

struct CloudDetails {
  std::vector<Eigen::Vector3d> normals_T;  ///< unit, out of the body; zero where undetermined
  /// 1-sigma, worst axis, unit of the cloud: of the landmarks by their image points, and of the
  /// whole cloud across its surface, for the map is bent (decision 0086). NaN for added points.
  std::vector<float> sigmas;
  std::vector<std::int32_t> views;  ///< keyframes that see its landmarks, summed; 0: added
};

/// A measured point is the mean of the landmarks in its cube. Its normal is that of its plane or of
/// the cylinder, else of its neighbours, and points to the cameras. An added point has the normal
/// of its side.
/// @param landmarks  from which the shape was estimated, in its unit.
/// @param edge       of the cubes of homogenise().
CloudDetails details_of(const Shape& shape,
                        const ShapeWork& work,
                        const ConfirmedLandmarks& landmarks,
                        double edge);

}  // namespace polhode::platform
