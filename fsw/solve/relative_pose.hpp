// Motion of a rigid body between two views of known correspondences, by five-point samples.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "base/fixed_vector.hpp"
#include "geometry/epipolar.hpp"

namespace polhode {

struct TwoViewOptions {
  double sigma_normalised = 1.0;  ///< 1-sigma of an image coordinate
  int samples = 60;  ///< at 60 % inliers 60 draws of five pairs miss with 1 % probability
  std::uint64_t seed = 0;
};

struct RelativePoseCandidate {
  RelativePose motion;  ///< p_ba of unit length
  double score = 0.0;   ///< truncated sum of squared Sampson errors, in sigma
  int inliers = 0;
};

/// Candidates kept. Chosen: each costs two adjustments, one for its depth-reversed solution.
inline constexpr std::size_t kRelativePoses = 3;
using RelativePoseCandidates = FixedVector<RelativePoseCandidate, kRelativePoses>;

/// The best candidates that differ in their rotation, best first; none when under eight pairs or
/// all samples fail. Many fit a small distant body: the caller refines and compares them.
/// @param x_a, x_b  normalised image points, pair by pair.
/// @cost `samples` minimal problems, up to ten solutions each, scored on all pairs.
/// @source Nister, PAMI 2004, via OpenGV.
RelativePoseCandidates find_relative_poses(std::span<const Eigen::Vector2d> x_a,
                                           std::span<const Eigen::Vector2d> x_b,
                                           const TwoViewOptions& options);

/// Depth of a point along its ray in a (z), by intersection of two rays; negative or infinite when
/// behind or parallel.
double depth_in_a(const RelativePose& motion,
                  const Eigen::Vector2d& x_a,
                  const Eigen::Vector2d& x_b);

}  // namespace polhode
