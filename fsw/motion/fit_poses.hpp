// The poses that the dynamics are fitted to: the whole past in a bounded number.
#pragma once

#include <algorithm>
#include <cstddef>

#include "motion/options.hpp"
#include "motion/pose_history.hpp"

namespace polhode {

/// Every other pose of the older half goes: the span stays, and successive poses of one side tell
/// little more than one of them.
inline void thin(PoseHistory& poses) {
  const std::size_t half = poses.size() / 2;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (i >= half || i % 2 == 0) {
      poses[kept++] = poses[i];
    }
  }
  poses.resize(kept);
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
    std::size_t old = 0;
    while (old < poses.size() &&
           seconds_between(poses[old].timestamp_ns, sample.timestamp_ns) > options.forgetting_s) {
      ++old;
    }
    std::copy(poses.begin() + old, poses.end(), poses.begin());
    poses.resize(poses.size() - old);
  }
  const auto limit = static_cast<std::size_t>(std::max(2, options.fit_poses_max));
  if (poses.full() || poses.size() >= limit) {
    thin(poses);
  }
  return poses.push_back(sample);
}

}  // namespace polhode
