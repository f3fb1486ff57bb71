// Best similarity between two sets of corresponding points.
#pragma once

#include <Eigen/Core>
#include <span>

#include "base/result.hpp"
#include "geometry/pose.hpp"

namespace polhode {

/// p_b = scale * R_ba * p_a + t_ba.
struct Similarity {
  double scale = 1.0;
  Eigen::Matrix3d R_ba = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_ba = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d apply(const Eigen::Vector3d& p_a) const {
    return scale * (R_ba * p_a) + t_ba;
  }
};

/// The pose of frame b in the camera, in b's unit, where `pose_a` is that of frame a in a's unit.
Pose transformed(const Pose& pose_a, const Similarity& b_of_a);

/// Scale and shift of the least-squares similarity whose rotation is given (Umeyama, PAMI 1991),
/// with weights >= 0.
/// @errors TooFewObservations (no weight), Degenerate (points coincide, or the scale would not be
/// positive).
Result<Similarity> align_rotated(std::span<const Eigen::Vector3d> points_a,
                                 std::span<const Eigen::Vector3d> points_b,
                                 std::span<const double> weights,
                                 const Eigen::Matrix3d& R_ba);

}  // namespace polhode
