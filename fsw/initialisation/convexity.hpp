// Which side of a body is near: only the near side of an opaque one is seen.
#pragma once

#include <span>

#include "solve/start_problem.hpp"

namespace polhode {

/// Curvature of the visible side in `frame`: the r^2 term of a quadratic depth fit over its
/// 1-sigma. Convex opaque bodies give a positive sign, their depth-reversed twins a negative one;
/// dishes and broken boxes fool it.
double convexity_cue(std::span<const StartSighting> sightings,
                     int frame,
                     const StartGeometryView& geometry);

}  // namespace polhode
