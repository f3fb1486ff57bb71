// A fit of the dynamics to the poses so far, as work apart from the step.
#pragma once

#include <cstdint>

#include "motion/estimator.hpp"

namespace polhode {

struct FitJob {
  MotionSnapshot snapshot;
  MotionWorkspace workspace;
  std::uint32_t poses_new = 0;  ///< since the fit before
  RigidModel model;             ///< the result
};

/// Copies the input of the fit, and the number of poses since the last fit.
void prepare_fit(const Map& map,
                 const MapDrift& drift,
                 const MotionOptions& options,
                 MotionEstimate* motion,
                 FitJob* job);

/// A pure function of the snapshot.
void run_fit(FitJob* job);

}  // namespace polhode
