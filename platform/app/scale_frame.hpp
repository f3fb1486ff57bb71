// Does the frame that a known length or a range belongs to exist?
#pragma once

#include "camera/replay/sequence.hpp"
#include "parameters/load.hpp"

namespace polhode::platform {

/// A reading is taken in the frame of exactly its time, a range as well as a length: of another
/// time it would be passed over in silence, and lengths would stay in map units. One within the
/// sequence's times may be of a frame that was dropped: that is reported on stderr; the run goes on
/// without it.
/// @throws UnusableInput where it lies outside, naming where the time was given, it, and those of
/// the first and the last frame.
void check_scale_frame(const Configuration& configuration, const Sequence& sequence);

}  // namespace polhode::platform
