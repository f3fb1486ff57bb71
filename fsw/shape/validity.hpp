// Validity of the last shape and of the scale: after they came from a file,
// or lay in memory that radiation reaches.
#pragma once

#include "shape/scale_state.hpp"
#include "shape/shape_state.hpp"

namespace polhode {

/// Counts within their tables, numbers finite, axes unit, kinds that exist.
bool is_valid(const ShapeState& shape);

bool is_valid(const ScaleState& scale);

}  // namespace polhode
