// The caller's memory as a component divides it.
#pragma once

#include <cstddef>

#include "pipeline/state.hpp"

namespace polhode {

/// The component and its state lie side by side.
struct alignas(64) Storage {
  Component::State state;
  alignas(Component) std::byte component[sizeof(Component)];
};

}  // namespace polhode
