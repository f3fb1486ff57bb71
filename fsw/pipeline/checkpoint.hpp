// The state with which a component continues where another left off: the map, the poses that the
// motion is estimated from, scale, counters. Data of a single frame and an initialisation under way
// are left out.
//
// The content is the tables as they lie in memory, for the same build only. Its first words
// identify the layout; another layout is refused. The caller that stores it checks that it is
// complete and of this build. Each value is checked all the same: a bit may have flipped before it
// was written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "pipeline/component.hpp"

namespace polhode {

/// Upper bound of a checkpoint's length in bytes.
std::size_t checkpoint_octets_max();

/// False while its memory is damaged; the next step repairs that.
bool may_be_saved(const Component& component);

/// Unused slots of tables are left out.
/// @param out  at least checkpoint_octets_max() long.
/// @return bytes written.
std::size_t save_checkpoint(const Component& component, std::span<std::uint8_t> out);

/// Into a component that has just been created. With a map the component begins in LOST: it
/// searches about the pose predicted by the motion, then over the whole map.
/// @return false, and the component is as it was created, when the bytes are of another layout,
/// truncated, or hold values that no component leaves (is_valid() of pipeline/soundness.hpp).
bool restore_checkpoint(std::span<const std::uint8_t> octets, Component* component);

}  // namespace polhode
