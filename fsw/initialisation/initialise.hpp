// The start of a map as a contest of hypotheses: commits only when the images decide between them.
#pragma once

#include "initialisation/options.hpp"
#include "initialisation/outcome.hpp"

namespace polhode {

/// Makes hypotheses, refines each and its depth-reversed twin, compares them on the same sightings,
/// decides. Poses and points of the winner are filled in whenever there is one, committed or not.
/// @cost bounded by counts: kSeeds short and eight long adjustments of kContestTracks, one of all
/// tracks. Deterministic in (problem, options).
StartOutcome run_start_contest(const StartProblem& problem,
                               const StartOptions& options,
                               StartWorkspace& workspace);

}  // namespace polhode
