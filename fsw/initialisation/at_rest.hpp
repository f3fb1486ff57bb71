// The hypothesis of a body at rest, of which only bearing and range change.
#pragma once

#include "initialisation/selection.hpp"

namespace polhode {

/// Fits the winner's geometry with attitudes that are constant in inertial axes. Replaces the
/// winner where the Bayesian information criterion prefers it to free rotation and to a constant
/// rate. Uses the workspace's finalists.
/// @return margin in favour of rest over free rotation, in chi-square; negative where the body
/// rotates. Zero where it is undecided: a constant rate beats rest, but free rotation does not.
/// @source Schwarz, Annals of Statistics 1978: 2 k unknowns fewer weigh k ln(n).
double compare_at_rest(Selection* selection, InitialWorkspace* workspace);

}  // namespace polhode
