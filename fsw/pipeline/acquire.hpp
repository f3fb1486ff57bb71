// Collects frames for a map: in ACQUIRING, and in LOST beside relocalisation.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// Keeps a frame that adds parallax. Issues a hypothesis selection once enough frames are kept.
void collect(Component::State* state);

}  // namespace polhode
