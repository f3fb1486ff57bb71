// The frame comes in: copied, judged, searched for the target and for features.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// Tells the caller's hook that a stage has ended.
void stage_done(Stage stage, const Component::State& state);

/// Clears what the last frame's picture has left behind.
void forget_picture(Component::State* state);

/// Imports the image, measures its quality and finds the target's mask.
FrameUse take_picture(const Frame& frame, Component::State* state);

/// Detects this frame's features, once.
void ensure_features(Component::State* state);

}  // namespace polhode
