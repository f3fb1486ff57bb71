// The observer's attitude at each frame.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// The observer's attitude at the frame that begins: the frame's own, else the one last reported by
/// command and turned on at its rate. With the first attitude of a run everything so far, for which
/// C stood in for I, is turned into I.
void set_observer(const StepInput& input, Component::State* state);

}  // namespace polhode
