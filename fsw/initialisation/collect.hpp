// Frames that are kept before there is a map, and the problem that is posed from them.
#pragma once

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
  bool asked_short = false;  ///< the last problem was posed without the oldest frames
  int since_asked = 0;       ///< frames kept since the last problem
};

/// Resets the state to that before the first frame.
void clear(InitialisationState* state);

/// Whether indices and sizes are within their tables, as long as no bit has flipped in memory.
bool is_valid(const InitialisationState& state);

/// Result of collect_frame().
struct Collected {
  bool kept = false;
  std::uint32_t tables_full = 0;  ///< tracks that found no place
};

/// Keeps a frame that adds parallax or rotation to the last one kept; drops older frames that share
/// no tracks with it.
/// @param ratio_max  of descriptors' distances, best to second best.
/// @param resting  receives the places of features that stay in the image while the body rotates.
Collected collect_frame(const CollectibleFrame& frame,
                        const CameraModel& camera,
                        double ratio_max,
                        InitialisationState* state,
                        RestingPlaces* resting);

/// Are there enough frames that the last problem did not contain?
bool wants_selection(const InitialOptions& options, const InitialisationState& state);

/// Poses the tracks so far as a problem for hypothesis selection. Alternates between two choices.
/// The newest frames that enough tracks span decide as soon as the body has rotated enough under
/// the same features. All frames decide where no feature lasts that long.
void pose_problem(const CameraModel& camera,
                  const InitialOptions& options,
                  std::uint64_t seed,
                  InitialisationState* state,
                  InitialisationJob* job);

}  // namespace polhode
