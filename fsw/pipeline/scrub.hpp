// Radiation flips bits in memory. The state kept from step to step is checked before it is used.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// At the beginning of a step. A table with impossible values keeps its valid entries, or is reset;
/// that is counted, and reported by an event. Damaged values that are possible are handled like
/// wrong measurements.
void scrub(Component::State* state);

}  // namespace polhode
