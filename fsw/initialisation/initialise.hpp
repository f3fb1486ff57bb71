// Initialisation by hypothesis selection: commits only when the images decide.
#pragma once

#include "initialisation/options.hpp"
#include "initialisation/outcome.hpp"

namespace polhode {

/// Makes hypotheses, refines each and its depth-reversed solution, compares them on the same
/// observations, decides. Fills poses and points of the winner, committed or not.
/// @cost bounded by counts: kSeeds short and eight long adjustments of limits::kSelectionTracks,
/// one of all tracks. Deterministic in (problem, options).
InitialOutcome select_hypothesis(const InitialProblem& problem,
                                 const InitialOptions& options,
                                 InitialWorkspace* workspace);

}  // namespace polhode
