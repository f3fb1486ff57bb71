// Written by tools/generate_bus.py from config/bus/*.toml: change those.
// What the component counts.
#pragma once

#include <cstdint>

namespace polhode {

// clang-format off
/// All start at 0, wrap at 2^32 and go to 0 by the command reset_counters.
struct Counters {
  std::uint32_t frames_in = 0;  ///< frames given to the component
  std::uint32_t frames_used = 0;  ///< frames that were processed
  std::uint32_t frames_unreadable = 0;  ///< frames that the camera could not deliver whole
  std::uint32_t frames_dark = 0;  ///< frames too dark to be used
  std::uint32_t frames_wrong_size = 0;  ///< frames whose size is not the camera's
  std::uint32_t frames_time_not_increasing = 0;  ///< frames not later than the one before, or by more than 30 years
  std::uint32_t frames_held = 0;  ///< frames skipped after HOLD
  std::uint32_t frames_missing = 0;  ///< frames that never came, judged by gaps in time
  std::uint32_t frames_flat = 0;  ///< frames without contrast; this kind and the next five are skipped, or used as degraded frames
  std::uint32_t frames_saturated = 0;  ///< frames far more saturated than those before
  std::uint32_t frames_frozen = 0;  ///< frames that repeat the previous image
  std::uint32_t frames_torn = 0;  ///< frames of which a part repeats the previous image
  std::uint32_t frames_bit_errors = 0;  ///< frames with damaged pixels, lines or blocks
  std::uint32_t frames_blurred = 0;  ///< frames far less sharp than those before
  std::uint32_t frames_with_care = 0;  ///< degraded frames: used for a pose only, not for the map
  std::uint32_t poses = 0;  ///< frames with a pose
  std::uint32_t lost = 0;  ///< times that the target was lost
  std::uint32_t relocalised = 0;  ///< times that the target was found again by its map
  std::uint32_t restarts = 0;  ///< times that a new map was begun after a loss
  std::uint32_t start_contests = 0;  ///< hypothesis selections, each an attempt to begin a map
  std::uint32_t keyframes_inserted = 0;  ///< keyframes added to the map
  std::uint32_t keyframes_culled = 0;  ///< keyframes removed from the map
  std::uint32_t landmarks_created = 0;  ///< landmarks added to the map
  std::uint32_t landmarks_culled = 0;  ///< landmarks removed from the map
  std::uint32_t closures = 0;  ///< loops closed
  std::uint32_t shapes = 0;  ///< estimates of the shape
  std::uint32_t jobs_issued = 0;  ///< initialisations, adjustments of the map, fits of the dynamics, shape estimates, tests of the camera
  std::uint32_t jobs_without_result = 0;  ///< jobs skipped because memory was short, and adjustments without a usable solution
  std::uint32_t steps_short_of_memory = 0;  ///< steps with reduced work because memory was short
  std::uint32_t scale_contradictions = 0;  ///< times that the readings of the scale began to contradict each other
  std::uint32_t tables_full = 0;  ///< times that a new entry found its table full
};
// clang-format on

}  // namespace polhode
