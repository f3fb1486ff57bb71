// The frames and tracks on which hypotheses are compared.
#pragma once

#include "initialisation/outcome.hpp"

namespace polhode {

/// Chooses the cores (runs of frames with many tracks in common) and the contest's tracks, spread
/// over the image.
/// @return false when no three frames have enough tracks in common.
bool select_contest_set(const StartProblem& problem, StartContestSet* set);

/// Is the set full, and has a frame fewer tracks in it than speak for one hypothesis or its twin,
/// and than it could have?
bool is_crowded(const StartProblem& problem, const StartContestSet& set);

}  // namespace polhode
