// Without a map, or after its loss: frames are collected until the contest of hypotheses decides how
// the body turns.
#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// Adds the frame to the collection when the picture has changed by enough, and holds a contest.
/// @return true when the contest commits: the outcome, over the collected frames, is in
/// `start_outcome`.
bool collect(Component::State* state);

}  // namespace polhode
