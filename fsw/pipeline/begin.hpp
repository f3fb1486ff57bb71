// A hypothesis selection has come back: the map begins, or begins anew after a loss.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// When the selection commits, its outcome becomes the map, or a further part of it after a loss;
/// the mode becomes TRACKING, and a joint adjustment is asked for.
void take_start(Component::State* state);

}  // namespace polhode
