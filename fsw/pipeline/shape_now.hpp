// The shape as far as the map shows it: estimated now and then as a job, and told on the bus.
#pragma once

#include <cstdint>
#include <optional>

#include "pipeline/component.hpp"
#include "shape/shape.hpp"

namespace polhode {

/// The last estimate, and the map that it was made from.
struct ShapeNow {
  std::optional<Shape> shape;
  std::uint32_t frame_of_estimate = 0;
  bool asked = false;
  bool is_new = false;  ///< the last estimate has come with this frame
  std::uint32_t frame_asked = 0;
  std::uint32_t keyframe_asked = 0;  ///< number of the next keyframe at that time
};

/// Asks for an estimate while the target is followed, the map has grown since the last one and
/// bus.shape_every_frames have passed; while there is none, a fifth of these.
void ask_for_shape(Component::State* state);

/// The estimate comes in; where there is none the last one stays.
void take_shape(Component::State* state);

/// T is another one from here on.
void forget_shape(Component::State* state);

/// Sends the packet when an estimate has come, and every bus.shape_every_frames frames.
void send_shape(const MotionState& motion, Component::State* state);

}  // namespace polhode
