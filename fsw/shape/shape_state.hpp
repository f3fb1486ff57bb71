// The last estimate of the shape, and when the next one is due.
#pragma once

#include <cstdint>
#include <optional>

#include "shape/shape.hpp"

namespace polhode {

/// The last estimate, and the map that it was made from.
struct ShapeState {
  std::optional<Shape> shape;
  std::uint32_t frame_of_estimate = 0;
  bool asked = false;
  bool is_new = false;  ///< the last estimate has come with this frame
  std::uint32_t frame_asked = 0;
  std::uint32_t keyframe_asked = 0;  ///< number of the next keyframe at that time
};

}  // namespace polhode
