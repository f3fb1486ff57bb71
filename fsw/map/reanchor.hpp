// After a loss: where a map that has begun anew lies in the T of the poses so far.
#pragma once

#include <Eigen/Core>
#include <span>

#include "base/result.hpp"
#include "geometry/alignment.hpp"
#include "geometry/pose.hpp"

namespace polhode {

/// One frame of the new start, as the start has it and as the motion before the loss predicts it.
struct ReanchorFrame {
  Pose start;                        ///< T': frame and unit of the new start
  Pose predicted;                    ///< T: frame and unit of the poses so far
  double predicted_sigma_rad = 0.0;  ///< 1-sigma of the worst direction, > 0
  double predicted_sigma_mu = 0.0;   ///< the same of the position
};

/// What is known of the body in T: bounds the depth, which a short turn tells badly.
struct ReanchorBody {
  Eigen::Vector3d centre_T = Eigen::Vector3d::Zero();
  double radius_mu = 1.0;
};

struct Reanchoring {
  Similarity to_T;          ///< takes T' to T
  double misfit_rad = 0.0;  ///< RMS disagreement of the attitudes after it
  double turn_rad = 0.0;    ///< largest turn of the start from its first frame
  /// Attitudes of the start and of the prediction turn alike: they differ by what the start's depth
  /// error makes of its turn and what the prediction's error can change meanwhile (an error that
  /// stays is part of to_T). Where they do not, one of the two motions is wrong. And the
  /// prediction's attitude is known to a radian in every frame: what may be anywhere agrees with
  /// anything.
  bool agrees = false;
};

/// Rotation: mean of the attitudes' differences, weighted by the prediction's variance. Scale and
/// origin: the start's path in the camera laid onto the predicted one, whose offset is as uncertain
/// as it says; the units differ by a third at most (1-sigma); the new landmarks, whose middle is
/// the origin of T', lie on the side of the body that faces the camera, half a radius from its
/// centre, give or take as much.
/// @errors TooFewObservations (under 3 frames), Degenerate (the radius is not positive, a sigma is
/// not, the scale would be negative).
Result<Reanchoring> reanchor_map(std::span<const ReanchorFrame> frames, const ReanchorBody& body);

}  // namespace polhode
