// How a target's mass lies, as another pass has found it.
#pragma once

#include <Eigen/Core>

#include "solve/rigid_body.hpp"

namespace polhode {

/// A target's inertia and mass centre in T, as a motion that was fitted has them. They are kept
/// from pass to pass until one knows them better. Fits of a later pass take them as a prior.
struct KnownBody {
  bool known = false;  ///< else the others are not valid
  InertiaShape shape = InertiaShape::Zero();
  InertiaShape shape_sigma = InertiaShape::Zero();
  Eigen::Vector3d mass_centre_T = Eigen::Vector3d::Zero();  ///< map units
  Eigen::Vector3d mass_centre_sigma = Eigen::Vector3d::Zero();
};

}  // namespace polhode
