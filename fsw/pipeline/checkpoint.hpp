// What a component must know to go on where another left off: the map, the poses that the motion is
// estimated from, scale, counters. Not what lives for one frame, and not a start that is under way.
//
// The content is the tables as they lie in memory, for the same build only: its first words tell
// the layout, and another one's is refused. Whoever stores it checks that it is whole and of this
// build. Each value is checked all the same: a bit may have flipped before it was written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "pipeline/component.hpp"

namespace polhode {

/// Octets that no checkpoint is longer than.
std::size_t checkpoint_octets_max();

/// Not while its memory is damaged: the next step puts that right.
bool may_be_saved(const Component& component);

/// Unused slots of tables are left out. @param out at least checkpoint_octets_max() long.
/// @return octets written.
std::size_t save_checkpoint(const Component& component, std::span<std::uint8_t> out);

/// Into a component that has just been created. With a map in it, the component begins as one that
/// has lost its target: it looks where the motion says, then everywhere.
/// @return false, and the component is as it was created, when the octets are of another layout,
/// cut off, or hold values that no component leaves (is_valid() of pipeline/soundness.hpp).
bool restore_checkpoint(std::span<const std::uint8_t> octets, Component* component);

}  // namespace polhode
