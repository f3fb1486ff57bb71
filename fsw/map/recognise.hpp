// A body that is known, in other light, from another range or another aspect: where hardly one in
// ten of the features that look alike is right, which a ratio test throws away and RANSAC does not
// find.
#pragma once

#include "map/localise.hpp"

namespace polhode {

/// So many agreeing blobs support a pose: four times what determines it.
inline constexpr int kAgreeingBlobsMin = 12;

/// Each feature and view of a landmark that look alike give a whole pose: by the blobs' places,
/// sizes and orientations. Poses that many of them give are fitted to those that support them, and
/// tried. One is taken whose blobs agree, beyond chance more of them than with one of another
/// aspect: of alike aspects one is as good as the other.
/// @param before  a pose of some frames before, tried too; null: there is none.
/// @return blobs that agree.
/// @cost  squared in features, as far as two for each are alike.
/// @errors TooFewObservations (no landmarks or no features), NoConsensus.
/// @source Lowe, IJCV 2004, section 7.3 (there by bins of similar transforms).
Result<int> recognise(const LocaliseInput& input,
                      const Pose* before,
                      LocaliseScratch* scratch,
                      LocalisedFrame* out);

/// Do two poses show the same aspect, as far as recognise() separates aspects?
bool is_same_aspect(const Pose& a, const Pose& b);

}  // namespace polhode
