// The frame comes in: copied, judged, searched for the target and for features.
#pragma once

#include <optional>

#include "pipeline/state.hpp"

namespace polhode {

/// Tells the caller's hook that a stage has ended.
void stage_done(Stage stage, const Component::State& state);

/// Clears what the last frame's picture has left behind.
void forget_picture(Component::State* state);

/// Pictures are looked at anew, after a pause or for another target: none is compared with the ones
/// before.
void forget_pictures(Component::State* state);

/// Imports the image alone.
FrameUse bring_picture(const Frame& frame, Component::State* state);

/// Imports the image and judges its quality.
FrameUse take_picture(const Frame& frame, Component::State* state);

/// Where the map's landmarks are in the picture with this pose.
MaskPrior mask_prior(const Pose& pose, Component::State* state);

/// Finds the target's mask; while a map is tracked and something may be behind it, with the
/// landmarks where the predicted pose has them.
void look_for_target(const std::optional<PosePrediction>& predicted, Component::State* state);

/// Detects this frame's features, once.
void ensure_features(Component::State* state);

}  // namespace polhode
