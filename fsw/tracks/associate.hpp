// Associates the features of two frames of the same body, before there is a map.
#pragma once

#include <span>

#include "features/match.hpp"

namespace polhode {

/// Mutual best descriptors (match_mutual), checked against the motion of neighbouring features:
/// neighbours on a body move alike. Matches with another motion are dropped. Features without a
/// match are searched for at the displacement of their neighbours, where there are few rivals.
/// @param a, b     features of an earlier and a later frame; at most limits::kFeatures.
/// @param matches  by index into `a`, ascending. With too few mutual matches for a field of motion:
/// these.
/// @cost the mutual match, and as many distances in the image.
void associate(std::span<const Feature> a,
               std::span<const Feature> b,
               double ratio_max,
               FeatureMatches* matches);

}  // namespace polhode
