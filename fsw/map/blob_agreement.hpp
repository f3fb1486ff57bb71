// Whether blobs look as a pose has them: how large, and which way their orientation points. It
// separates a right pose from one that many features agree with by their places alone.
#pragma once

#include "map/localise.hpp"

namespace polhode {

/// Inliers whose blob is about as large and oriented as the landmark's most alike view has it, seen
/// from the frame's pose. Of a right pose it is two thirds of them, also in other light; of a wrong
/// one a tenth.
int agreeing_blobs(const LocaliseInput& input, const LocalisedFrame& frame);

}  // namespace polhode
