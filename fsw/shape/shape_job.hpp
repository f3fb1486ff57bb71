// An estimate of the shape, as work apart from the step, and when the next one is due.
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
  std::optional<Shape> outcome;  ///< the result; none: not run, or there was too little to see
};

/// Is an estimate due? Not before the map has another keyframe, nor `every_frames` after the last.
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

/// A pure function of what was prepared.
void run_shape(ShapeJob* job);

/// The last job gave nothing, or was lost: the next one does not wait for another keyframe. A body
/// that is mapped all around may never give one.
void ask_shape_again(ShapeState* state);

/// What came of it; there must be an outcome.
/// @param frame  that it was prepared in.
/// @return it differs from the last one in its planes or its completion.
bool take_shape(const ShapeJob& job, std::uint32_t frame, ShapeState* state);

}  // namespace polhode
