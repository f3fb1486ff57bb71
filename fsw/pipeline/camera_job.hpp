// A test of the stated camera by the map's keyframes, as work apart from the step.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "geometry/camera_model.hpp"
#include "map/window.hpp"
#include "solve/camera_verdict.hpp"

namespace polhode {

/// How the images of a map's keyframes move, by differences between the keyframes beside each. Zero
/// where those are too far apart to tell.
using MapMotions = FixedVector<PoseMotion, limits::kKeyframes>;
MapMotions motions_of(const AdjustmentSnapshot& map);

/// A whole map's problem. Its motions are another's to keep.
CameraProblem camera_problem_of(const MapMotions& motions,
                                const CameraModel& camera,
                                AdjustmentSnapshot* map);

/// As much of an adjusted map as the test works on: keyframes evenly over its time, and the
/// landmarks that they see best.
struct CameraJob {
  // More make an iteration longer as their cube: 68 took three times as long as 32.
  static constexpr std::size_t kPoses = 32;
  // More make the sigma smaller as 1/sqrt(N), and the test longer as N. With 3000 a principal point
  // that was 60 px away was not told on the sample in flight, by a hair.
  static constexpr std::size_t kObservations = 4200;
  FixedVector<InverseDepthPose, kPoses> poses;
  FixedVector<std::uint8_t, kPoses> pose_fixed;
  FixedVector<PoseMotion, kPoses> motions;
  FixedVector<Eigen::Vector3d, kObservations / 3> points_T;  ///< as few (choose_points)
  FixedVector<BundleObservation, kObservations> observations;
  double middle_normalised = 0.0;
  double height_normalised = 1.0;
  double interval_s = 1.0;
  CameraFit fit;  ///< the result
};

/// What is remembered of the tests. It is the camera's: it outlives maps and targets.
struct CameraState {
  bool waits = false;               ///< a test is prepared, and waits to be issued
  std::uint32_t next_keyframe = 0;  ///< number of the map's next one when that was prepared
  CameraFinding found;
};

/// Copies what the test needs of an adjusted map. Its first pose, which is held, takes part.
void prepare_camera_test(const CameraProblem& map, CameraJob* job);

/// A pure function of what was prepared.
void run_camera_test(CameraJob* job);

/// A test without a result changes nothing.
void take_camera_test(const CameraFit& fit, CameraState* state);

[[nodiscard]] bool is_valid(const CameraState& state);

}  // namespace polhode
