// The hypothesis that the body does not rotate: what moves is its bearing and range.
#pragma once

#include "initialisation/selection.hpp"

namespace polhode {

/// Fits the winner's geometry with attitudes that are constant in inertial axes. Where it explains
/// the images as well for the unknowns that it saves, against free rotation and against a steady
/// one, it becomes the winner. Uses the workspace's finalists.
/// @return the evidence for it against free rotation, in chi-square; negative where the body
/// rotates, and zero where it is undecided whether it does: a steady rotation explains more than
/// rest, and free rotation not enough more for its unknowns.
/// @source Schwarz, Annals of Statistics 1978: 2 k unknowns fewer weigh k ln(n).
double compare_at_rest(Selection* selection, StartWorkspace* workspace);

}  // namespace polhode
