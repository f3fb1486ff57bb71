// Adjustment of the map: a window of keyframes on the way, all of them when a side comes back.
#pragma once

#include "base/fixed_vector.hpp"
#include "config/limits.hpp"
#include "geometry/camera_model.hpp"
#include "map/map.hpp"
#include "solve/bundle_adjustment.hpp"

namespace polhode {

/// Copy of the part of the map that an adjustment works on; the adjustment itself needs nothing
/// else. Some 3 MB: not for the stack.
struct AdjustmentSnapshot {
  FixedVector<KeyframeId, limits::kKeyframes> keyframes;
  FixedVector<InverseDepthPose, limits::kKeyframes> poses;
  FixedVector<std::uint8_t, limits::kKeyframes> pose_fixed;
  FixedVector<LandmarkId, limits::kLandmarks> landmarks;
  FixedVector<Eigen::Vector3d, limits::kLandmarks> points_T;
  FixedVector<std::uint8_t, limits::kLandmarks> point_fixed;
  FixedVector<BundleObservation, limits::kAdjustmentSightings> observations;
  std::uint32_t left_out = 0;  ///< sightings that found the table full: those of the last keyframes
};

/// The newest keyframe and those that share most landmarks with it, `window` in all, free to move;
/// up to twice as many others that see the same landmarks, held.
void snapshot_window(const Map& map,
                     const CameraModel& camera,
                     int window,
                     AdjustmentSnapshot* snapshot);

/// Every keyframe and every landmark. The newest keyframe is held.
void snapshot_all(const Map& map, const CameraModel& camera, AdjustmentSnapshot* snapshot);

BundleReport adjust(AdjustmentSnapshot* snapshot,
                    const BundleOptions& options,
                    BundleWorkspace* workspace);

/// Writes the result back. Where no more than one keyframe was held the whole map is first brought
/// back onto where it was by the similarity that fits its landmarks best: T's axes, origin and
/// scale do not move.
void apply(const AdjustmentSnapshot& snapshot, Map* map);

}  // namespace polhode
