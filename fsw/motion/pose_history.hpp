// The poses that motion is estimated from.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "geometry/pose.hpp"

namespace polhode {

struct PoseSample {
  std::int64_t timestamp_ns = 0;
  Pose pose;
  PoseCovariance covariance =
      PoseCovariance::Zero();  ///< of (phi, dp), in C; both diagonal blocks positive definite
};

/// With components of another frame X in C's place; as turned() of a pose.
inline PoseSample turned(const Eigen::Matrix3d& R_XC, const PoseSample& sample) {
  return {.timestamp_ns = sample.timestamp_ns,
          .pose = turned(R_XC, sample.pose),
          .covariance = turned(R_XC, sample.covariance)};
}

/// Time strictly increasing. The caller owns it.
using PoseHistory = FixedVector<PoseSample, limits::kMotionPoses>;

/// Appends; when full, the oldest goes.
/// @return false, nothing changed, when `sample` is not later than the last one.
[[nodiscard]] inline bool remember(PoseHistory& history, const PoseSample& sample) {
  if (!history.empty() && sample.timestamp_ns <= history.back().timestamp_ns) {
    return false;
  }
  if (history.full()) {
    history.erase(0);
  }
  return history.push_back(sample);
}

/// Seconds from `from_ns` to `to_ns`, exact to rounding however large the time stamps are.
[[nodiscard]] inline double seconds_between(std::int64_t from_ns, std::int64_t to_ns) {
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

}  // namespace polhode
