// Joint adjustment of poses and points to their images.
#pragma once

#include "solve/bundle_problem.hpp"

namespace polhode {

/// Levenberg-Marquardt by Ceres with the points eliminated (Schur complement), each observation
/// under a Cauchy loss, each prior under one of its own. Deterministic.
/// @return not usable without observations, where a point lies behind a camera that sees it, or
/// where no step can be computed; poses and points are then as they were.
/// @cost at most iterations_max linear systems of 6 per moving pose; heap by
/// adjustment_bytes_max().
/// @source Agarwal et al., Bundle Adjustment in the Large, ECCV 2010; Triggs et al., Bundle
/// Adjustment - A Modern Synthesis, 2000.
BundleReport adjust_bundle(const BundleProblem& problem, const BundleOptions& options);

}  // namespace polhode
