// The poses that the dynamics are fitted to: the past, of a bounded number of turns and in a
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

// A fit integrates from pose to pose: 32 turns take 4000 steps for each of its iterations, and
// beyond that it would cost more the longer the run. 32 turns tell a rate to 5e-6 of itself by
// poses that are good to a milliradian.
inline constexpr double kFitTurnsMax = 32.0;

/// What is more than `age_s` before `now_ns` goes.
inline void forget(double age_s, std::int64_t now_ns, PoseHistory& poses) {
  const auto young = std::find_if(poses.begin(), poses.end(), [&](const PoseSample& sample) {
    return seconds_between(sample.timestamp_ns, now_ns) <= age_s;
  });
  poses.resize(
      static_cast<std::size_t>(std::copy(young, poses.end(), poses.begin()) - poses.begin()));
}

/// Of the last poses, over a chord that is long against their noise; 0 where they hardly turn.
[[nodiscard]] inline double turning_rad_s(const PoseHistory& poses) {
  constexpr double kChord_rad = 0.4;
  const PoseSample& last = poses.back();
  for (std::size_t i = poses.size() - 1; i-- > poses.size() / 2;) {
    const double turned_rad = rotation_angle_rad(poses[i].pose.R_CT, last.pose.R_CT);
    if (turned_rad > kChord_rad) {
      return turned_rad / seconds_between(poses[i].timestamp_ns, last.timestamp_ns);
    }
  }
  return 0.0;
}

/// Every other pose of the older half goes: the span stays, and successive poses of one side tell
/// little more than one of them. So do poses of kFitTurnsMax turns ago.
inline void thin(PoseHistory& poses) {
  const std::size_t half = poses.size() / 2;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i >= half || i % 2 == 0) {
      poses[kept++] = poses[i];
    }
  }
  poses.resize(kept);
  if (const double rate_rad_s = turning_rad_s(poses); rate_rad_s > 0.0) {
    forget(2.0 * std::numbers::pi * kFitTurnsMax / rate_rad_s, poses.back().timestamp_ns, poses);
  }
}

/// Whether a fit is worth its time.
/// @param poses  remembered; `poses_since_fit` of them are not in the model
[[nodiscard]] inline bool fit_is_due(const RigidModel& model,
                                     std::size_t poses,
                                     std::size_t poses_since_fit) {
  if (poses < kModelPosesMin) {
    return false;
  }
  if (model.of_map && model.accepted()) {
    return poses_since_fit > poses / 4;  // the map has not grown, and the next joint fit is far
  }
  // One pose in twenty tells little more; from nothing a fit costs tens of times as much.
  return poses_since_fit >= (model.accepted() ? 1 + poses / 20 : 2 + poses / 8);
}

/// Appends; what is older than the forgetting time goes, and a full table is thinned.
/// @return false, nothing changed, when `sample` is not later than the last one.
[[nodiscard]] inline bool remember_for_fit(PoseHistory& poses,
                                           const PoseSample& sample,
                                           const MotionOptions& options) {
  if (!poses.empty() && sample.timestamp_ns <= poses.back().timestamp_ns) {
    return false;
  }
  if (options.forgetting_s > 0.0) {
    forget(options.forgetting_s, sample.timestamp_ns, poses);
  }
  const auto limit = static_cast<std::size_t>(std::max(2, options.fit_poses_max));
  if (poses.full() || poses.size() >= limit) {
    thin(poses);
  }
  return poses.push_back(sample);
}

}  // namespace polhode
