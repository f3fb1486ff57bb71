// Which frames are kept before there is a map, and what they are asked.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "features/detect.hpp"
#include "geometry/camera_model.hpp"
#include "initialisation/initialisation_job.hpp"
#include "initialisation/options.hpp"
#include "tracks/track_table.hpp"

namespace polhode {

/// The state of this room: frames with their features, and tracks over them.
struct InitialisationState {
  TrackTable tracks;
  bool asked_short = false;  ///< the last problem left out the oldest frames
  int since_asked = 0;       ///< frames kept since the last problem
};

/// As before the first frame.
void clear(InitialisationState* state);

/// Whether indices and sizes are within their tables, as long as no bit has flipped in memory.
bool is_valid(const InitialisationState& state);

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
/// @param resting  takes the places of what stays in the image while the body turns.
Collected collect_frame(const CollectibleFrame& frame,
                        const CameraModel& camera,
                        double ratio_max,
                        InitialisationState* state,
                        RestingPlaces* resting);

/// Is there enough that the last problem did not hold?
bool wants_selection(const InitialOptions& options, const InitialisationState& state);

/// The tracks so far as a problem for hypothesis selection. In turns of the newest frames, as many
/// as enough tracks span, and of all frames: the former decide as soon as a body has turned enough
/// under the same features, the latter where features last too short for that.
void pose_problem(const CameraModel& camera,
                  const InitialOptions& options,
                  std::uint64_t seed,
                  InitialisationState* state,
                  InitialisationJob* job);

}  // namespace polhode
