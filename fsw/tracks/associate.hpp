// Associates the features of two frames of the same body, before there is a map.
#pragma once

#include <span>

#include "features/match.hpp"

namespace polhode {

/// Mutual best descriptors (match_mutual), held against how the features about them move:
/// neighbours on a body move alike. What moves otherwise is dropped, and features without a match
/// are looked for again where their neighbours went; there a descriptor has few rivals.
/// @param a, b     features of an earlier and a later frame; at most limits::kFeatures.
/// @param matches  by index into `a`, ascending. With too few mutual matches for a field of motion:
/// these.
/// @cost the mutual match, and as many distances in the image.
void associate(std::span<const Feature> a,
               std::span<const Feature> b,
               double ratio_max,
               FeatureMatches* matches);

}  // namespace polhode
