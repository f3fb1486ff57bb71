// Selection of the frames and tracks on which hypotheses are compared.
#pragma once

#include "initialisation/outcome.hpp"

namespace polhode {

/// Chooses the cores, runs of frames with many tracks in common, and the tracks of the selection,
/// spread over the image.
/// @return false when no three frames have enough tracks in common.
bool choose_selection_set(const InitialProblem& problem, SelectionSet* set);

/// Is the set full, with too few tracks in a frame that has enough of them? Then fewer frames would
/// decide more.
bool is_crowded(const InitialProblem& problem, const SelectionSet& set);

}  // namespace polhode
