// The servicer's own parts in the view of a component.
#pragma once

#include "mask/own_structure.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// Before the first step; a restart keeps it. The packets are then a function of it, too.
/// @param own  of the camera's size: nothing there is target. It must outlive the component. Null:
/// nothing is the servicer's.
void set_own_structure(const OwnStructure* own, Component* component);

}  // namespace polhode
