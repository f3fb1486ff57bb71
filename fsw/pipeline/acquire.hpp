// Without a map, or after its loss: frames are collected until the contest of hypotheses decides
// how the body turns.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// Adds the frame to the collection when the picture has changed by enough, and asks for a contest.
/// While a job is out, and by a frame that is used with care, the collection stays as it is.
void collect(Component::State* state);

}  // namespace polhode
