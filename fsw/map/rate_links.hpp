// What holds the keyframes of a map together beside the landmarks they share: a body's rate of
// rotation does not change at once.
#pragma once

#include "map/window.hpp"

namespace polhode {

/// Links each three successive keyframes of the snapshot by the two rates of rotation between them,
/// in the observer's inertial axes. A young map, whose landmarks leave its turns nearly free, does
/// not bend then. Keyframes that lie far apart are not linked, nor any that are all held.
void add_rate_links(AdjustmentSnapshot* snapshot);

}  // namespace polhode
