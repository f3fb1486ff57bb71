// Bundle adjustment of the map: of a window of keyframes, and of all of them at a loop closure.
#pragma once

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "geometry/alignment.hpp"
#include "geometry/camera_model.hpp"
#include "map/map.hpp"
#include "solve/bundle_adjustment.hpp"

namespace polhode {

/// Pose priors and rate links of an adjustment's keyframes, by the body's motion.
struct MotionTerms {
  FixedVector<PosePrior, limits::kKeyframes> priors;
  FixedVector<RateLink, limits::kKeyframes> links;
};

/// Copy of the part of the map that an adjustment changes, and its only input. Some 3 MB: not for
/// the stack.
struct AdjustmentSnapshot {
  FixedVector<KeyframeId, limits::kKeyframes> keyframes;
  FixedVector<std::uint32_t, limits::kKeyframes> keyframe_numbers;
  FixedVector<InverseDepthPose, limits::kKeyframes> poses;
  FixedVector<std::uint8_t, limits::kKeyframes> pose_fixed;
  FixedVector<std::int64_t, limits::kKeyframes> timestamps_ns;  ///< of the keyframes,
  FixedVector<Eigen::Matrix3d, limits::kKeyframes> R_IC;        ///< the observer's attitude then
  MotionTerms motion;
  FixedVector<LandmarkId, limits::kLandmarks> landmarks;
  FixedVector<std::int32_t, limits::kLandmarks> landmark_numbers;
  FixedVector<Eigen::Vector3d, limits::kLandmarks> points_T;
  FixedVector<std::uint8_t, limits::kLandmarks> point_fixed;
  FixedVector<BundleObservation, limits::kAdjustmentObservations> observations;
  std::uint32_t next_keyframe_number = 0;  ///< of the map; keyframes from it on are newer
  std::int32_t next_landmark_number = 0;
  std::uint32_t left_out =
      0;  ///< observations of the oldest keyframes, for which the table had no room
};

/// The newest keyframe and those that share most landmarks with it, `window` in all, free to move;
/// up to twice as many others that see the same landmarks, fixed.
void snapshot_window(const Map& map,
                     const CameraModel& camera,
                     int window,
                     AdjustmentSnapshot* snapshot);

/// Every keyframe and every landmark. The newest keyframe is fixed.
void snapshot_all(const Map& map, const CameraModel& camera, AdjustmentSnapshot* snapshot);

/// As the solver sees it.
BundleProblem problem_of(AdjustmentSnapshot* snapshot);

BundleReport adjust(AdjustmentSnapshot* snapshot, const BundleOptions& options);

/// How the newest keyframe of a snapshot was moved. Poses and points added since move along.
struct MapCorrection {
  std::int64_t timestamp_ns =
      INT64_MAX;  ///< of that keyframe; INT64_MAX: it is gone, or nothing was changed
  std::uint32_t frame = UINT32_MAX;
  Pose before;
  Pose after;
  Similarity back;  ///< applied to the whole snapshot to restore the gauge; else identity

  [[nodiscard]] Pose moved(const Pose& pose) const {
    const Eigen::Matrix3d R = pose.R_CT * before.R_CT.transpose();
    return {.R_CT = R * after.R_CT, .p_CT = R * (after.p_CT - before.p_CT) + pose.p_CT};
  }
  [[nodiscard]] Eigen::Vector3d moved_point(const Eigen::Vector3d& p_T) const {
    return after.R_CT.transpose() * (before.to_camera(p_T) - after.p_CT);
  }
};

/// Writes the result back to those keyframes and landmarks of the snapshot that are still in the
/// map. Where at most one keyframe was fixed the gauge is restored first: T's axes by the
/// keyframes' published attitudes, its origin and scale by the landmarks. Newer keyframes and
/// landmarks move with the snapshot's newest keyframe. A result with the body behind a camera is
/// rejected.
MapCorrection apply(const AdjustmentSnapshot& snapshot, Map* map);

}  // namespace polhode
