// The end of a replay: re-estimation from all frames, and the files that come of it.
#pragma once

#include <filesystem>
#include <span>

#include "app/camera_check.hpp"
#include "app/observations.hpp"
#include "app/servicer_attitude.hpp"
#include "camera/replay/sequence.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {

/// Results of the run, frame by frame.
struct ReplayLog {
  std::span<const MotionState> published;
  std::span<const FrameUse> uses;
  ObservationSpool& observations;
  const ServicerAttitude& servicer;
};

/// Writes motion_smoothed.csv, the trajectories (*.tum), the clouds, shape.json and
/// motion_model.json into `folder`. Lengths and poses in them are in the target's body frame:
/// origin in the centroid, axes from the shape (T's own where no shape was found).
/// @return the test of the stated camera with the converged map.
CameraReport finish_replay(Component& component,
                           const Sequence& sequence,
                           const ReplayLog& log,
                           const std::filesystem::path& folder);

}  // namespace polhode::platform
