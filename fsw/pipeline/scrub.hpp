// Bits flip in memory that radiation reaches. What the component remembers from step to step is
// looked through before it is computed with.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// At the beginning of a step. A table that holds what no step leaves goes on with what is sound of
/// it, or is reset; that is counted, and reported by an event. Values that are damaged but possible
/// are left to what each step does about wrong measurements.
void scrub(Component::State* state);

}  // namespace polhode
