// What a new keyframe sets off: new landmarks, adjustment, culling.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// A map has just begun, or begun anew with the keyframe of this number: asks for its joint
/// adjustment, after which come the landmarks that those keyframes give beyond the start's tracks,
/// and a second one.
void settle_map(std::uint32_t first_keyframe, Component::State* state);

/// Should this frame become a keyframe, and may it? While a start is sought the map does not grow;
/// while it is being adjusted it does, and the result is merged.
bool may_extend_map(const Component::State& state);

/// Makes this frame a keyframe, extends the map by it and asks for an adjustment, which waits for
/// the one that is out.
void extend_map(Component::State* state);

/// An adjustment has come back: the map takes it over and is culled. What was derived from the
/// adjusted keyframes follows: this frame's pose, those remembered, the reference of optical flow,
/// and what has come since. Asks for the next one if the map has grown meanwhile.
void take_adjustment(Component::State* state);

/// Joint adjustment of all keyframes and landmarks, here and now.
void adjust_all(int iterations_max, Component::State* state);

/// Sightings and landmarks that do not fit go; the noise scale is measured anew.
void cull_map(Component::State* state);

}  // namespace polhode
