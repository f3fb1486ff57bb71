// Validity checks of the bus's own state, after it was read from a file.
#pragma once

#include "bus/bus_state.hpp"

namespace polhode {

/// Checks the members that continue after a restart: sequence counts in their 14 bits, numbers
/// finite, quaternions of unit norm, kinds that exist.
bool is_valid(const BusState& bus);

/// Parts of it:
bool is_valid(const ServicerAttitude& servicer);
bool is_valid(const Reported& reported);
bool is_valid(const ScaleNumber& scale);

}  // namespace polhode
