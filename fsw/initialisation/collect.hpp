// Which frames are kept before there is a map, and what they are asked.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "features/detect.hpp"
#include "geometry/camera_model.hpp"
#include "initialisation/options.hpp"
#include "initialisation/start_job.hpp"
#include "tracks/track_table.hpp"

namespace polhode {

/// The state of this room: frames with their features, and tracks over them.
struct InitialisationState {
  TrackTable tracks;
};

/// A frame whose features are on the target.
struct CollectibleFrame {
  std::uint32_t frame = 0;
  std::int64_t timestamp_ns = 0;
  Eigen::Matrix3d R_IC = Eigen::Matrix3d::Identity();  ///< the observer's attitude
  const Features* features = nullptr;
};

/// What came of a frame.
struct Collected {
  bool kept = false;
  std::uint32_t tables_full = 0;  ///< tracks that found no place
};

/// Keeps a frame that tells something about depth beyond the last one kept; drops older ones that
/// it is not connected to.
/// @param ratio_max  of descriptors' distances, best to second best.
Collected collect_frame(const CollectibleFrame& frame,
                        double ratio_max,
                        InitialisationState* state);

/// The tracks so far as a problem for hypothesis selection.
void pose_problem(const InitialisationState& state,
                  const CameraModel& camera,
                  const StartOptions& options,
                  std::uint64_t seed,
                  StartJob* job);

}  // namespace polhode
