// The end of a replay: re-estimation from all frames, and the files that come of it.
#pragma once

#include <filesystem>

#include "app/observations.hpp"
#include "camera/replay/sequence.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

/// Writes motion_smoothed.csv, trajectory.tum, the clouds, shape.json and motion_model.json into
/// `folder`.
void finish_replay(Component& component,
                   const Sequence& sequence,
                   ObservationSpool& observations,
                   const std::filesystem::path& folder);

}  // namespace polhode::platform
