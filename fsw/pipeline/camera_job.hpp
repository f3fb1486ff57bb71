// A test of the configured camera model by the map's keyframes, as a job beside the step.
#pragma once

#include <cstddef>
#include <cstdint>

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "geometry/camera_model.hpp"
#include "map/window.hpp"
#include "solve/camera_verdict.hpp"

namespace polhode {

/// Image motion at each keyframe, by differences between its neighbours. Zero where the neighbours
/// are too far apart for a rate.
using MapMotions = FixedVector<PoseMotion, limits::kKeyframes>;
MapMotions motions_of(const AdjustmentSnapshot& map);

/// The problem of a whole map. The caller keeps `motions` alive.
CameraProblem camera_problem_of(const MapMotions& motions,
                                const CameraModel& camera,
                                AdjustmentSnapshot* map);

/// The part of an adjusted map used by the test: keyframes evenly spread in time, and their best
/// observed landmarks.
struct CameraJob {
  // An iteration's time grows with the cube of this: 68 took three times as long as 32.
  static constexpr std::size_t kPoses = 32;
  // The sigma falls as 1/sqrt(N), and the time grows as N. With 3000 a principal point wrong by 60
  // px was just missed on the sample in flight.
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

/// State of the tests. It belongs to the camera, so it outlives maps and targets.
struct CameraState {
  bool waits = false;               ///< a test is prepared, and waits to be issued
  std::uint32_t next_keyframe = 0;  ///< number of the map's next one when the test was prepared
  CameraFinding found;
};

/// Copies the test's part of an adjusted map, with the first pose, which is fixed.
void prepare_camera_test(const CameraProblem& map, CameraJob* job);

/// A pure function of the prepared job.
void run_camera_test(CameraJob* job);

/// A test without a result changes nothing.
void take_camera_test(const CameraFit& fit, CameraState* state);

[[nodiscard]] bool is_valid(const CameraState& state);

}  // namespace polhode
