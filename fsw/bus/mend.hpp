// The bus's own state, put right after bit flips.
#pragma once

#include "base/repair.hpp"
#include "bus/bus_state.hpp"

namespace polhode {

/// Nothing happens to a sound one. What is not sound becomes what it is at the start; counts of
/// packets lose the bits that they do not have. A cloud on its way with impossible counts ends.
Repair repair(BusState* bus);

}  // namespace polhode
