// Warm-up before the first frame: brings code, tables and libraries into memory.
#pragma once

#include "app/component_memory.hpp"
#include "pipeline/parameters.hpp"

namespace polhode::platform {

/// Steps a component through images of a made-up rotating body, from the features to the map and
/// its jobs, then ends it. Only effects on the process remain: one-time work of libraries, pages
/// that are present, and symbols that are bound. The component of the run is made afterwards, in
/// the same memory.
/// @return frames that had a pose.
int warm_up(const ComponentMemory& memory, const Parameters& parameters);

}  // namespace polhode::platform
