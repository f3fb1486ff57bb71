// Convexity cue: only the near faces of an opaque body are visible, and most bodies are convex.
#pragma once

#include <span>

#include "solve/initial_problem.hpp"

namespace polhode {

/// Curvature of the visible face in `frame`: the r^2 term of a quadratic fit of depth, over its
/// 1-sigma. Positive for convex opaque bodies, negative for their depth-reversed solutions. Dishes
/// and broken boxes give the wrong sign.
double convexity_cue(std::span<const TrackObservation> observations,
                     int frame,
                     const InitialGeometryView& geometry);

}  // namespace polhode
