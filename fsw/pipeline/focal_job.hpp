// A test of the camera's focal length by the map's keyframes, as work apart from the step.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "solve/focal_adjustment.hpp"

namespace polhode {

/// As much of an adjusted map as the test works on: keyframes evenly over its time, and the
/// landmarks that they see best.
struct FocalJob {
  // More make an iteration longer as their cube: 68 took three times as long as 32.
  static constexpr std::size_t kPoses = 32;
  // More make the sigma smaller as 1/sqrt(N), and the test longer as N. With 1500 a focal length
  // that was 15 % too short was not refuted on the sample, at 3.8 sigma.
  static constexpr std::size_t kObservations = 3000;
  FixedVector<InverseDepthPose, kPoses> poses;
  FixedVector<std::uint8_t, kPoses> pose_fixed;
  FixedVector<Eigen::Vector3d, kObservations / 3> points_T;  ///< as few (choose_points)
  FixedVector<BundleObservation, kObservations> observations;
  FocalReport report;  ///< the result
};

/// What is remembered of the tests. It is the camera's: it outlives maps and targets.
struct FocalState {
  bool waits = false;               ///< a test is prepared, and waits to be issued
  std::uint32_t next_keyframe = 0;  ///< number of the map's next one when that was prepared
  FocalReport found;                ///< of the last test that decided
};

/// Copies what the test needs of an adjusted map. Its first pose, which is held, takes part.
void prepare_focal(const BundleProblem& map, FocalJob* job);

/// A pure function of what was prepared.
void run_focal(FocalJob* job);

/// A test that decided nothing changes nothing.
void take_focal(const FocalReport& report, FocalState* state);

[[nodiscard]] bool is_sound(const FocalState& state);

}  // namespace polhode
