// Rate links: constraints between successive keyframes beside their common landmarks. A free body's
// rate of rotation changes slowly.
#pragma once

#include "map/window.hpp"

namespace polhode {

/// Links each three successive keyframes of the snapshot by the two rates of rotation between them,
/// in the observer's inertial axes. A young map, whose landmarks leave its turns nearly free, does
/// not bend then. Keyframes far apart in time are not linked, nor links made if all are fixed.
void add_rate_links(AdjustmentSnapshot* snapshot);

}  // namespace polhode
