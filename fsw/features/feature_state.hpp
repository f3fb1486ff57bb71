// This frame's features, and the memory of detection.
#pragma once

#include "features/feature.hpp"
#include "features/resting.hpp"
#include "features/workspace.hpp"
#include "geometry/image_motion.hpp"

namespace polhode {

/// The state of this room.
struct FeatureState {
  Features features;
  bool ready = false;        ///< detection has run in this frame
  ImageMotion image_motion;  ///< expected in this frame; zero where all rows are of one time
  RestingPlaces resting;
  FeatureWorkspace workspace;
};

}  // namespace polhode
