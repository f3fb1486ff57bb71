// Metres per map unit, as soon as what carries the scale has been seen.
#pragma once

#include "pipeline/state.hpp"
#include "shape/scale_state.hpp"

namespace polhode {

/// Where the configuration names a length or a range in a frame, and that frame is this one or a
/// keyframe, they are read, and read anew each time the map has grown by half: a map of a few
/// frames is bent, and its lengths are off by percents. Lengths are published in metres from then
/// on, unless readings contradict each other.
void measure_scale(Component::State* state);

/// The same at once, in place of what an earlier reading said: from the keyframe of the named time,
/// or from this frame as it was localised last. False where nothing can be told.
bool measure_scale_in_keyframe(Component::State* state);
bool measure_scale_in_frame(Component::State* state);

/// From a found shape in map units, where the configuration names a diameter or an edge.
bool measure_scale_of(const Shape& shape, Component::State* state);

}  // namespace polhode
