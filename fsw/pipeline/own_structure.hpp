// The servicer's own parts in the view of a component.
#pragma once

#include "mask/own_structure.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// For a call before the first step; a restart keeps the mask. The packets then depend on it, too.
/// @param own  of the camera's size; its pixels are never target. It must outlive the component.
/// Null: no own structure is visible.
void set_own_structure(const OwnStructure* own, Component* component);

}  // namespace polhode
