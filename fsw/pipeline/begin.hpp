// A contest has been won: the map begins, or begins anew after a loss.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// Makes the map of `start_outcome` with a first joint adjustment; the mode becomes TRACKING, the
/// poses of the start's frames are remembered and this frame has its own.
void begin(Component::State* state);

/// After a loss. T stays: the new start is bridged to it by the motion so far, and the published
/// sigmas grow by what that motion leaves open. The old map stays beside the new part, and joins it
/// when one of its sides comes back; it goes when its motion contradicts the new start's, which was
/// decided on its own, and when the tables have no room for both.
void begin_again(Component::State* state);

}  // namespace polhode
