// Takes the result of a hypothesis selection: begins the map, or re-initialises it after a loss.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// When the selection commits, its outcome becomes the map, or a further part of it after a loss.
/// The mode becomes TRACKING, and a joint adjustment is requested.
void take_start(Component::State* state);

}  // namespace polhode
