// Joint adjustment of poses and points to their images.
#pragma once

#include "solve/bundle_problem.hpp"

namespace polhode {

/// Levenberg-Marquardt with the points eliminated (Schur complement), residuals re-weighted by the
/// Cauchy loss. Within a point's observations those of one pose follow each other.
/// @cost at most iterations_max linear systems of 6 per moving pose. No heap; deterministic.
/// @source Triggs et al., Bundle Adjustment - A Modern Synthesis, 2000 (elimination); Nielsen,
/// IMM-REP-1999-05 (damping).
BundleReport adjust_bundle(const BundleProblem& problem,
                           const BundleOptions& options,
                           BundleWorkspace* workspace);

}  // namespace polhode
