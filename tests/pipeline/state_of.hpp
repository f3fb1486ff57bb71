// What a component remembers, for tests to look into.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

inline Component::State& state_of(Component& component) {
  return *ComponentAccess::state(component);
}

inline const Component::State& state_of(const Component& component) {
  return *ComponentAccess::state(component);
}

}  // namespace polhode
