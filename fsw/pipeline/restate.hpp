// After the first adjustments of a map its poses so far are measured anew.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// The poses of the start's frames, anew from a map that has changed, in the poses so far; this
/// frame's own when it is one of them.
void restate_poses(Component::State* state);

}  // namespace polhode
