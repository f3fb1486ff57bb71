// Map re-anchoring after a loss: aligns a newly initialised map with the T of the poses so far.
#pragma once

#include <Eigen/Core>
#include <span>

#include "base/result.hpp"
#include "geometry/alignment.hpp"
#include "geometry/pose.hpp"

namespace polhode {

/// One frame of the new initialisation, with its pose there and as predicted by the motion before
/// the loss.
struct ReanchorFrame {
  Pose start;                        ///< T': frame and unit of the new map
  Pose predicted;                    ///< T: frame and unit of the poses so far
  double predicted_sigma_rad = 0.0;  ///< 1-sigma of the worst direction, > 0
  double predicted_sigma_mu = 0.0;   ///< the same of the position
};

/// Centre and radius of the body in T: they bound the depth, which a short rotation leaves
/// uncertain.
struct ReanchorBody {
  Eigen::Vector3d centre_T = Eigen::Vector3d::Zero();
  double radius_mu = 1.0;
};

struct Reanchoring {
  Similarity to_T;          ///< takes T' to T
  double misfit_rad = 0.0;  ///< RMS disagreement of the attitudes after it
  double turn_rad = 0.0;    ///< largest rotation of the new map from its first frame
  /// The attitudes of the new map and of the prediction differ by no more than two errors: that of
  /// the new map's rotation, and the change of the prediction's (a constant one is part of to_T).
  /// Otherwise one of the two motions is wrong. The prediction's attitude is also known to a radian
  /// in every frame: an unknown one would agree with any.
  bool agrees = false;
};

/// Rotation: mean of the attitude differences, weighted by the prediction's variance. Scale and
/// origin: least-squares alignment of the translations in the camera, with three priors. The
/// predicted offset has its given sigma. The units differ by a third (1-sigma). The new landmarks,
/// whose mean is the origin of T', lie half a radius from the centre towards the camera, with a
/// sigma of half a radius.
/// @errors TooFewObservations (under 3 frames), Degenerate (the radius is not positive, a sigma is
/// not, the scale would be negative).
Result<Reanchoring> reanchor_map(std::span<const ReanchorFrame> frames, const ReanchorBody& body);

}  // namespace polhode
