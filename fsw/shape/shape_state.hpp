// The last estimate of the shape, and the schedule of the next.
#pragma once

#include <cstdint>
#include <optional>

#include "shape/shape.hpp"

namespace polhode {

/// The last estimate, and the state of the map that it was made from.
struct ShapeState {
  std::optional<Shape> shape;
  std::uint32_t frame_of_estimate = 0;
  bool asked = false;
  bool is_new = false;  ///< the last estimate has come in this frame
  std::uint32_t frame_asked = 0;
  std::uint32_t keyframe_asked = 0;  ///< number of the next keyframe at that time
};

}  // namespace polhode
