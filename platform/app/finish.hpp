// The end of a replay: re-estimation from all frames, and the files that come of it.
#pragma once

#include <filesystem>
#include <span>

#include "app/observations.hpp"
#include "app/servicer_attitude.hpp"
#include "camera/replay/sequence.hpp"
#include "pipeline/component.hpp"
#include "solve/focal_adjustment.hpp"

namespace polhode::platform {

/// What the run has left behind, frame by frame.
struct ReplayLog {
  std::span<const MotionState> published;
  std::span<const FrameUse> uses;
  ObservationSpool& observations;
  const ServicerAttitude& servicer;
};

/// Writes motion_smoothed.csv, the trajectories (*.tum), the clouds, shape.json and
/// motion_model.json into `folder`. Lengths and poses in them are in the target's body frame:
/// origin in the centroid, axes from the shape (T's own where no shape was found).
/// @return the focal length that the map at rest speaks for.
FocalReport finish_replay(Component& component,
                          const Sequence& sequence,
                          const ReplayLog& log,
                          const std::filesystem::path& folder);

}  // namespace polhode::platform
