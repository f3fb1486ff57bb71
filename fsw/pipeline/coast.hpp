// COASTING: a frame that cannot be used, while the motion still predicts the target's pose.
#pragma once

#include <cstdint>
#include <optional>

#include "geometry/pose_prediction.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// The predicted pose, where it may be published for a measured one (decision 0099).
std::optional<PosePrediction> coasted_pose(std::int64_t timestamp_ns,
                                           const Component::State& state);

/// For a frame that was not used. The target's state is reported by prediction, until that is too
/// uncertain.
void coast(std::int64_t timestamp_ns, Component::State* state);

}  // namespace polhode
