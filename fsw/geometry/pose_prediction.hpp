// A pose predicted for a time, with its covariance.
#pragma once

#include <cstddef>

#include "geometry/pose.hpp"

namespace polhode {

struct PosePrediction {
  Pose pose;
  PoseCovariance covariance =
      PoseCovariance::Zero();  ///< of (phi, dp) as in pose.hpp; rotation and position uncorrelated
  std::size_t rotation_poses = 0;
  std::size_t position_poses = 0;
};

/// With components of another frame X in C's place; as turned() of a pose.
inline PosePrediction turned(const Eigen::Matrix3d& R_XC, PosePrediction predicted) {
  predicted.pose = turned(R_XC, predicted.pose);
  predicted.covariance = turned(R_XC, predicted.covariance);
  return predicted;
}

}  // namespace polhode
