// ACQUIRING, and LOST beside relocalisation: frames are collected for a map.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// Keeps the frame, where it tells of depth; asks for a hypothesis selection when there are enough.
void collect(Component::State* state);

}  // namespace polhode
