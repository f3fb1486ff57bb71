// Estimate of the shape as a job, and its schedule.
#pragma once

#include <cstdint>
#include <optional>

#include "config/limits.hpp"
#include "map/map.hpp"
#include "shape/shape_state.hpp"

namespace polhode {

/// Lengths in map units.
struct ShapeJob {
  FixedVector<Eigen::Vector3d, limits::kLandmarks> landmarks_T;
  ShapeOptions options;
  std::uint64_t seed = 0;
  std::optional<Shape> previous;
  ShapeWork work;
  std::optional<Shape> outcome;  ///< the result; none: not run, or too few landmarks
};

/// Is an estimate due? Yes with a new keyframe, `every_frames` after the last one.
[[nodiscard]] bool shape_is_due(const ShapeState& state,
                                const Map& map,
                                std::uint32_t frame,
                                std::uint32_t every_frames);

/// Copies the confirmed landmarks.
void prepare_shape(const Map& map,
                   const ShapeOptions& options,
                   std::uint64_t seed,
                   std::uint32_t frame,
                   ShapeState* state,
                   ShapeJob* job);

/// A pure function of the prepared job.
void run_shape(ShapeJob* job);

/// After a job that failed or was lost: the next one does not wait for a keyframe. A body that is
/// fully mapped may never give one.
void ask_shape_again(ShapeState* state);

/// Takes the job's outcome, which must be there.
/// @param frame  in which the job was prepared.
/// @return whether planes or completion differ from the last ones.
bool take_shape(const ShapeJob& job, std::uint32_t frame, ShapeState* state);

}  // namespace polhode
