// Resets of several rooms at once. Each room resets itself.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// Resets the map and everything derived from it: motion, shape, jobs that are out. The scale is
/// reset with a new T only.
void reset_map_and_motion(Component::State* state);

/// Resets the target: the map, frames collected for one, its scale, the history of images.
/// Parameters, counters, the servicer's attitude and the number of T are kept.
void reset_target(Component::State* state);

/// Resets the data that is stale after a pause: flow reference, collected frames, history of
/// images.
void pause(Component::State* state);

}  // namespace polhode
