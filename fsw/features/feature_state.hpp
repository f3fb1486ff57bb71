// This frame's features, and the memory that finds them.
#pragma once

#include "features/feature.hpp"
#include "features/resting.hpp"
#include "features/workspace.hpp"

namespace polhode {

/// The state of this room.
struct FeatureState {
  Features features;
  bool ready = false;  ///< they have been looked for in this frame
  RestingPlaces resting;
  FeatureWorkspace workspace;
};

}  // namespace polhode
