// Written by tools/generate_bus.py from config/bus/*.toml: change those.
// What the component counts.
#pragma once

#include <cstdint>

namespace polhode {

// clang-format off
/// All start at 0, wrap at 2^32 and go to 0 by the command reset_counters.
struct Counters {
  std::uint32_t frames_in = 0;  ///< handed over
  std::uint32_t frames_used = 0;  ///< that were looked at
  std::uint32_t frames_unreadable = 0;  ///< that the camera could not deliver whole
  std::uint32_t frames_dark = 0;  ///< too dark to be used
  std::uint32_t frames_wrong_size = 0;
  std::uint32_t frames_time_not_increasing = 0;
  std::uint32_t frames_held = 0;  ///< passed over while held
  std::uint32_t frames_missing = 0;  ///< that never came, by the gaps in time
  std::uint32_t frames_flat = 0;  ///< without contrast; this and the next five: skipped, or used with care
  std::uint32_t frames_saturated = 0;  ///< far more saturated than those before
  std::uint32_t frames_frozen = 0;  ///< the previous picture once more
  std::uint32_t frames_torn = 0;  ///< a part of which is the previous picture's
  std::uint32_t frames_bit_errors = 0;  ///< with pixels, lines or blocks that are not of the picture
  std::uint32_t frames_blurred = 0;  ///< far less sharp than those before
  std::uint32_t frames_with_care = 0;  ///< used for a pose, not for the map
  std::uint32_t poses = 0;  ///< frames with a pose
  std::uint32_t lost = 0;  ///< times that tracking was lost
  std::uint32_t relocalised = 0;  ///< times that it was found again
  std::uint32_t restarts = 0;  ///< times that a map was begun anew after a loss
  std::uint32_t start_contests = 0;  ///< attempts at starting a map
  std::uint32_t keyframes_inserted = 0;
  std::uint32_t keyframes_culled = 0;
  std::uint32_t landmarks_created = 0;
  std::uint32_t landmarks_culled = 0;
  std::uint32_t closures = 0;  ///< loops closed
  std::uint32_t shapes = 0;  ///< estimates of the shape
  std::uint32_t jobs_issued = 0;  ///< starts, adjustments, fits of the motion, shapes
  std::uint32_t jobs_without_result = 0;  ///< skipped for want of memory
  std::uint32_t steps_short_of_memory = 0;  ///< in which less was asked of the libraries
  std::uint32_t scale_contradictions = 0;  ///< times that the readings of the scale stopped agreeing
  std::uint32_t tables_full = 0;  ///< times that a table had no free slot
};
// clang-format on

}  // namespace polhode
