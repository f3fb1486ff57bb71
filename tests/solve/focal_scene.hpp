// A bundle whose images were made with another focal length than they are normalised with.
#pragma once

#include <algorithm>

#include "bundle_scene.hpp"

namespace polhode::testing {

/// A body three radii away, seen by a camera whose focal length is taken for `part` of what it is.
inline BundleScene focal_scene(
    double part, std::uint64_t seed, double distance = 3.0, int poses = 12, int points = 60) {
  BundleScene s = make_scene(poses, points, 0.0, seed);
  Rng rng(seed, 91);
  for (InverseDepthPose& pose : s.poses) {
    pose.uvs.z() = 1.0 / distance;
  }
  for (BundleObservation& o : s.observations) {
    Eigen::Vector2d image = Eigen::Vector2d::Zero();
    const bool seen = reproject(s.poses[static_cast<std::size_t>(o.pose)],
                                s.points_T[static_cast<std::size_t>(o.point)],
                                &image);
    POLHODE_ASSERT(seen, o.point);
    image += kBundleSigma * Eigen::Vector2d(rng.normal(), rng.normal());
    o.normalised = image / part;
    o.sigma_normalised = kBundleSigma / part;
  }
  std::fill(s.pose_fixed.begin() + 1, s.pose_fixed.end(), std::uint8_t{0});
  return disturbed(s, seed, 0.2);
}

}  // namespace polhode::testing
