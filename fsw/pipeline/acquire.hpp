// ACQUIRING: frames are collected until the contest of hypotheses decides how the body turns.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// Adds the frame to the collection when the picture has changed by enough, and holds a contest. On
/// a commit the map is made, the mode becomes TRACKING and the frame has its pose.
void acquire(Component::State* state);

}  // namespace polhode
