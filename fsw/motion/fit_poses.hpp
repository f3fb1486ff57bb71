// The poses that the dynamics are fitted to: past ones, over a bounded number of rotations and in a
// bounded number.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "geometry/so3.hpp"
#include "motion/options.hpp"
#include "motion/pose_history.hpp"
#include "motion/rigid_model.hpp"

namespace polhode {

// A fit integrates from pose to pose: 32 rotations by kRotationStepAngle_rad are 4000 steps an
// iteration. More cost more the longer the run is (decision 0050). Poses good to a
// milliradian give a rate to 1e-3 / (32 x 2 pi) = 5e-6 of itself.
inline constexpr double kFitTurnsMax = 32.0;

/// Removes poses of more than `age_s` before `now_ns`.
inline void remove_older(double age_s, std::int64_t now_ns, PoseHistory& poses) {
  const auto young = std::find_if(poses.begin(), poses.end(), [&](const PoseSample& sample) {
    return seconds_between(sample.timestamp_ns, now_ns) <= age_s;
  });
  poses.resize(
      static_cast<std::size_t>(std::copy(young, poses.end(), poses.begin()) - poses.begin()));
}

/// Rotation rate of the last poses; 0 where they hardly rotate.
[[nodiscard]] inline double rotation_rad_s(const PoseHistory& poses) {
  // Chosen: a pose noise of 0.02 rad is a twentieth of it, and most runs have rotated by it soon.
  constexpr double kChord_rad = 0.4;
  const PoseSample& last = poses.back();
  for (std::size_t i = poses.size() - 1; i-- > poses.size() / 2;) {
    const double rotated_rad = rotation_angle_rad(poses[i].pose.R_CT, last.pose.R_CT);
    if (rotated_rad > kChord_rad) {
      return rotated_rad / seconds_between(poses[i].timestamp_ns, last.timestamp_ns);
    }
  }
  return 0.0;
}

/// Removes every other pose of the older half. The span stays, and successive poses of one visible
/// face share their errors. Removes poses of more than kFitTurnsMax rotations ago, too.
inline void thin(PoseHistory& poses) {
  const std::size_t half = poses.size() / 2;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i >= half || i % 2 == 0) {
      poses[kept++] = poses[i];
    }
  }
  poses.resize(kept);
  if (const double rate_rad_s = rotation_rad_s(poses); rate_rad_s > 0.0) {
    remove_older(
        2.0 * std::numbers::pi * kFitTurnsMax / rate_rad_s, poses.back().timestamp_ns, poses);
  }
}

/// Whether a fit is worth its time.
/// @param poses            stored
/// @param poses_since_fit  of these, not in the model
[[nodiscard]] inline bool fit_is_due(const RigidModel& model,
                                     std::size_t poses,
                                     std::size_t poses_since_fit) {
  if (poses < kModelPosesMin) {
    return false;
  }
  if (model.of_map && model.accepted()) {
    // A quarter more: the map has not grown for long, and the next joint fit is far. Chosen.
    return poses_since_fit > poses / 4;
  }
  // A twentieth more poses (decision 0050), or an eighth without a model to start from: then
  // a fit costs 40 times as much.
  return poses_since_fit >= (model.accepted() ? 1 + poses / 20 : 2 + poses / 8);
}

/// Appends. Removes poses older than the forgetting time, and thins a full table.
/// @return false, nothing changed, when `sample` is not later than the last one.
[[nodiscard]] inline bool remember_for_fit(PoseHistory& poses,
                                           const PoseSample& sample,
                                           const MotionOptions& options) {
  if (!poses.empty() && sample.timestamp_ns <= poses.back().timestamp_ns) {
    return false;
  }
  if (options.forgetting_s > 0.0) {
    remove_older(options.forgetting_s, sample.timestamp_ns, poses);
  }
  const auto limit = static_cast<std::size_t>(std::max(2, options.fit_poses_max));
  if (poses.full() || poses.size() >= limit) {
    thin(poses);
  }
  return poses.push_back(sample);
}

}  // namespace polhode
