// Adjustment of the map: a window of keyframes on the way, all of them when a side comes back.
#pragma once

#include <vector>

#include "geometry/camera_model.hpp"
#include "map/map.hpp"
#include "solve/bundle_adjustment.hpp"

namespace polhode {

/// Copy of the part of the map that an adjustment works on; the adjustment itself needs nothing
/// else.
struct AdjustmentSnapshot {
  std::vector<KeyframeId> keyframes;
  std::vector<InverseDepthPose> poses;
  std::vector<std::uint8_t> pose_fixed;
  std::vector<LandmarkId> landmarks;
  std::vector<Eigen::Vector3d> points_T;
  std::vector<std::uint8_t> point_fixed;
  std::vector<BundleObservation> observations;
};

/// The newest keyframe and those that share most landmarks with it, `window` in all, free to move;
/// up to twice as many others that see the same landmarks, held.
AdjustmentSnapshot snapshot_window(const Map& map, const CameraModel& camera, int window);

/// Every keyframe and every landmark. The newest keyframe is held.
AdjustmentSnapshot snapshot_all(const Map& map, const CameraModel& camera);

BundleReport adjust(AdjustmentSnapshot* snapshot,
                    const BundleOptions& options,
                    BundleWorkspace* workspace);

/// Writes the result back. Where no more than one keyframe was held the whole map is first brought
/// back onto where it was by the similarity that fits its landmarks best: T's axes, origin and
/// scale do not move.
void apply(const AdjustmentSnapshot& snapshot, Map* map);

}  // namespace polhode
