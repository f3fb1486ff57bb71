// What is forgotten, and when. Each room resets itself; here stands which ones go together.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// The map, and all that rests on it: motion, shape, what is being worked out from them. The scale
/// goes with a new T only.
void reset_map_and_motion(Component::State* state);

/// The target: the map, what was collected for one, its scale, the pictures so far. What lasts are
/// parameters, counters, the servicer's attitude and the number of T.
void reset_target(Component::State* state);

/// Frames are no longer looked at: what was collected is old when they are again.
void pause(Component::State* state);

}  // namespace polhode
