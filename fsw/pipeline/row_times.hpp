// Rows of a rolling shutter: the expected motion of the map's landmarks in the image.
#pragma once

#include <cstdint>

#include "geometry/image_motion.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// The image motion at a time, by the target's motion over the readout. None without a motion, and
/// with a global shutter. The servicer's attitude is assumed constant over the readout.
ImageMotion expected_image_motion(std::int64_t timestamp_ns, const Component::State& s);

}  // namespace polhode
