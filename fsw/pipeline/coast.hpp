// COASTING: a frame that cannot be looked at, while the motion still says where the target is.
#pragma once

#include <cstdint>
#include <optional>

#include "geometry/pose_prediction.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// The motion's prediction where it may stand in for a pose (decision 0099).
std::optional<PosePrediction> coasted_pose(std::int64_t timestamp_ns,
                                           const Component::State& state);

/// For a frame that was not used. What is told of its target is predicted, until that is too
/// uncertain.
void coast(std::int64_t timestamp_ns, Component::State* state);

}  // namespace polhode
