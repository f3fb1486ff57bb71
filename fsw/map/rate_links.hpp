// Rate links: constraints between successive keyframes beside their common landmarks. A free body's
// rate of rotation changes slowly.
#pragma once

#include "map/window.hpp"

namespace polhode {

/// Links each three successive keyframes of the snapshot by the two rates of rotation between them,
/// in the observer's inertial axes. The landmarks of a young map leave its rotations nearly free;
/// links keep it from bending. Keyframes far apart in time are not linked, nor those that are all
/// fixed.
void add_rate_links(AdjustmentSnapshot* snapshot);

}  // namespace polhode
