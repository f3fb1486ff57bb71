// Checks the state with which a component continues after a restart.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// Checks each room, the parameters' ranges and their CRC.
bool is_valid(const Component::State& state);

}  // namespace polhode
