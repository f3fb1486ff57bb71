// Warm-up before the first frame: brings code, tables and libraries into memory.
#pragma once

#include "app/component_memory.hpp"
#include "pipeline/parameters.hpp"

namespace polhode::platform {

/// Steps a component through a made-up body that turns, from the features to the map and its jobs,
/// then ends it: nothing of it is left but what libraries do once, pages that are present, and
/// symbols that are bound. The component of the run is made afterwards, in the same memory.
/// @return frames that had a pose.
int warm_up(const ComponentMemory& memory, const Parameters& parameters);

}  // namespace polhode::platform
