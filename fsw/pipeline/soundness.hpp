// Whether what a component goes on with after a restart may be computed with.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// Asks each room, and whether the parameters are the ones whose CRC is beside them, in their
/// ranges.
bool is_valid(const Component::State& state);

}  // namespace polhode
