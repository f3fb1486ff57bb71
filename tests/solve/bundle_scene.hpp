// A bundle of known poses and points, with exact or noisy images, for the tests of its adjustment.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/assert.hpp"
#include "base/rng.hpp"
#include "geometry/so3.hpp"
#include "solve/bundle_problem.hpp"

namespace polhode::testing {

// Half a pixel of a camera of a thousand pixels a radian.
inline constexpr double kBundleSigma = 5e-4;

struct BundleScene {
  std::vector<InverseDepthPose> poses;
  std::vector<std::uint8_t> pose_fixed;
  std::vector<Eigen::Vector3d> points_T;
  std::vector<std::uint8_t> point_fixed;
  std::vector<BundleObservation> observations;

  BundleProblem problem() {
    return {.poses = poses,
            .pose_fixed = pose_fixed,
            .points_T = points_T,
            .point_fixed = point_fixed,
            .observations = observations};
  }
};

inline Eigen::Vector3d normal3(Rng* rng) { return {rng->normal(), rng->normal(), rng->normal()}; }

/// A body of radius 1 ten radii away that turns by 10 deg from pose to pose; the first two poses
/// are held: rotation, translation and scale have no freedom left.
inline BundleScene make_scene(int poses, int points, double noise_sigmas, std::uint64_t seed) {
  Rng rng(seed, 81);
  BundleScene s;
  const Eigen::Vector3d axis = Eigen::Vector3d(0.2, 1.0, -0.1).normalized();
  for (int k = 0; k < poses; ++k) {
    const Pose pose{.R_CT = so3_exp(0.175 * k * axis),
                    .p_CT = {0.05 * k, -0.02 * k, 10.0 + 0.1 * k}};
    s.poses.push_back(to_inverse_depth(pose));
    s.pose_fixed.push_back(k < 2 ? 1 : 0);
  }
  for (int i = 0; i < points; ++i) {
    s.points_T.push_back(normal3(&rng).normalized());
    s.point_fixed.push_back(0);
  }
  for (int k = 0; k < poses; ++k) {
    for (int i = 0; i < points; ++i) {
      Eigen::Vector2d image = Eigen::Vector2d::Zero();
      const bool seen = reproject(
          s.poses[static_cast<std::size_t>(k)], s.points_T[static_cast<std::size_t>(i)], &image);
      POLHODE_ASSERT(seen, i);
      image += noise_sigmas * kBundleSigma * Eigen::Vector2d(rng.normal(), rng.normal());
      s.observations.push_back(
          {.pose = k, .point = i, .normalised = image, .sigma_normalised = kBundleSigma});
    }
  }
  return s;
}

/// By some six sigma of the images, or by a part of that.
inline BundleScene disturbed(const BundleScene& truth, std::uint64_t seed, double part = 1.0) {
  Rng rng(seed, 82);
  BundleScene s = truth;
  for (std::size_t k = 0; k < s.poses.size(); ++k) {
    if (s.pose_fixed[k] == 0) {
      s.poses[k].R_CT = so3_exp(part * 0.02 * normal3(&rng)) * s.poses[k].R_CT;
      s.poses[k].uvs +=
          part * Eigen::Vector3d(2e-3 * rng.normal(), 2e-3 * rng.normal(), 1e-3 * rng.normal());
    }
  }
  for (std::size_t i = 0; i < s.points_T.size(); ++i) {
    if (s.point_fixed[i] == 0) {
      s.points_T[i] += part * 0.03 * normal3(&rng);
    }
  }
  return s;
}

}  // namespace polhode::testing
