// A body that is known, in other light, from another range or another side: where hardly one in
// ten of the features that look alike is right, which a ratio test throws away and RANSAC does not
// find.
#pragma once

#include "map/localise.hpp"

namespace polhode {

/// Each feature and view of a landmark that look alike give a whole pose: by the blobs' places,
/// sizes and orientations. Poses that many of them give are tried. A pose that is not beyond chance
/// better than one of another side is none: of alike sides one is as good as the other.
/// @cost  squared in features, as far as two for each are alike.
/// @errors TooFewObservations (no landmarks or no features), NoConsensus.
/// @source Lowe, IJCV 2004, section 7.3 (there by bins of similar transforms).
Result<bool> recognise(const LocaliseInput& input, LocaliseScratch* scratch, LocalisedFrame* out);

/// As localise_guided() about a pose that is known to 20 deg.
Result<bool> localise_roughly(const LocaliseInput& input,
                              const Pose& pose,
                              LocaliseScratch* scratch,
                              LocalisedFrame* out);

/// Do two poses show the same side, as far as recognise() tells sides apart?
bool is_same_side(const Pose& a, const Pose& b);

}  // namespace polhode
