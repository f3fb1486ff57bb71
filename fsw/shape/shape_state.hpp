// The last estimate of the shape, and the schedule of the next.
#pragma once

#include <cstdint>
#include <optional>

#include "shape/shape.hpp"

namespace polhode {

/// The last estimate, the frame whose map it was made from, and the last request for an estimate.
struct ShapeState {
  std::optional<Shape> shape;
  std::uint32_t frame_of_estimate = 0;
  bool asked = false;
  bool is_new = false;  ///< the last estimate has come in this frame
  std::uint32_t frame_asked = 0;
  std::uint32_t keyframe_asked = 0;  ///< the map's next_keyframe_number then; 0: ask again
};

}  // namespace polhode
