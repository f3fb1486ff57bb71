// A bundle whose images were made by another camera than they are taken to be of.
#pragma once

#include <algorithm>
#include <vector>

#include "bundle_scene.hpp"
#include "geometry/so3.hpp"
#include "solve/camera_adjustment.hpp"

namespace polhode::testing {

struct CameraScene {
  BundleScene bundle;
  std::vector<PoseMotion> motions;

  CameraProblem problem() {
    return {.bundle = bundle.problem(), .motions = motions, .height_normalised = 0.7};
  }
};

struct CameraSceneOptions {
  double distance = 3.0;  ///< in radii of the body
  int poses = 12;
  int points = 60;
};

inline Deviations deviating(Deviation deviation, double value) {
  Deviations d = Deviations::Zero();
  d[static_cast<Eigen::Index>(deviation)] = value;
  return d;
}

/// A body seen by a camera that deviates; a second from pose to pose. By the equations of the
/// images, not by the adjustment's.
inline CameraScene camera_scene(const Deviations& d,
                                std::uint64_t seed,
                                CameraSceneOptions o = {}) {
  CameraScene s{.bundle = make_scene(o.poses, o.points, 0.0, seed), .motions = {}};
  Rng rng(seed, 91);
  // The body turns about a second axis, too, so that no two views differ by a turn in the image.
  std::vector<Pose> truth;
  for (std::size_t k = 0; k < s.bundle.poses.size(); ++k) {
    const double t = static_cast<double>(k);
    truth.push_back({.R_CT = so3_exp({0.0, 0.0, 0.35 * t}) * s.bundle.poses[k].R_CT,
                     .p_CT = {0.05 * t, -0.02 * t, o.distance}});
    s.bundle.poses[k] = to_inverse_depth(truth.back());
  }
  const auto last = static_cast<double>(truth.size() - 1);
  for (std::size_t k = 0; k < truth.size(); ++k) {
    const std::size_t a = k == 0 ? 0 : k - 1;
    const std::size_t b = std::min(k + 1, truth.size() - 1);
    PoseMotion motion{.phase = static_cast<double>(k) / last - 0.5};
    motion.rates << so3_log(truth[b].R_CT * truth[a].R_CT.transpose()),
        s.bundle.poses[b].uvs - s.bundle.poses[a].uvs;
    motion.rates /= static_cast<double>(b - a);
    s.motions.push_back(motion);
  }
  for (BundleObservation& observation : s.bundle.observations) {
    const auto k = static_cast<std::size_t>(observation.pose);
    const Eigen::Vector3d& p_T = s.bundle.points_T[static_cast<std::size_t>(observation.point)];
    const Eigen::Vector2d at_middle = truth[k].to_camera(p_T).hnormalized();
    // Where the point is when its row is read.
    const double late_s = d[5] * at_middle.y() / 0.7 + d[6] * (at_middle.y() < 0.0 ? -0.5 : 0.5);
    const PoseMotion& motion = s.motions[k];
    const Eigen::Vector3d uvs = s.bundle.poses[k].uvs + late_s * motion.rates.tail<3>();
    const Pose then = from_inverse_depth(
        {.R_CT = so3_exp(late_s * motion.rates.head<3>()) * truth[k].R_CT, .uvs = uvs});
    const Eigen::Vector2d ray = then.to_camera(p_T).hnormalized();
    const double focal = std::exp(d[0] + motion.phase * d[1]);
    const double root = std::exp(0.5 * d[2]);
    observation.normalised = {focal / root * ray.x() + d[3], focal * root * ray.y() + d[4]};
    observation.normalised += kBundleSigma * Eigen::Vector2d(rng.normal(), rng.normal());
  }
  std::fill(s.bundle.pose_fixed.begin() + 1, s.bundle.pose_fixed.end(), std::uint8_t{0});
  s.bundle = disturbed(s.bundle, seed, 0.2);
  return s;
}

}  // namespace polhode::testing
