// The observer's attitude at each frame.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// Sets the observer's attitude at this frame: the frame's own, else the last commanded one,
/// propagated at its rate. Before the first attitude of a run, I is C. With the first attitude the
/// data so far is rotated into I.
void set_observer(const StepInput& input, Component::State* state);

}  // namespace polhode
