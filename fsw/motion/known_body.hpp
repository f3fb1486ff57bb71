// Inertia and mass centre of a target, from another pass.
#pragma once

#include <Eigen/Core>

#include "solve/rigid_body.hpp"

namespace polhode {

/// A target's inertia and mass centre in T, from a fitted motion. They are kept from pass to pass
/// until more precise ones replace them. Fits of a later pass take them as a prior.
struct KnownBody {
  bool known = false;  ///< else the others are not valid
  InertiaShape shape = InertiaShape::Zero();
  InertiaShape shape_sigma = InertiaShape::Zero();
  Eigen::Vector3d mass_centre_T = Eigen::Vector3d::Zero();  ///< map units
  Eigen::Vector3d mass_centre_sigma = Eigen::Vector3d::Zero();
};

}  // namespace polhode
