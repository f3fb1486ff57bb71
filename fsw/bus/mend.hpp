// Repair of the bus's own state after bit flips.
#pragma once

#include "base/repair.hpp"
#include "bus/bus_state.hpp"

namespace polhode {

/// Leaves a valid state unchanged. Invalid parts take their initial values; counts of packets are
/// cut to their width. A cloud in transmission with impossible counts ends.
Repair repair(BusState* bus);

}  // namespace polhode
