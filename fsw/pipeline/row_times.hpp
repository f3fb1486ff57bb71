// Rows of a rolling shutter: how the map's landmarks are expected to move in the picture.
#pragma once

#include <cstdint>

#include "geometry/image_motion.hpp"
#include "pipeline/component.hpp"

namespace polhode {

/// The image motion at a time, by the target's motion over the readout. None without a motion,
/// and where all rows are of one time. The servicer is taken to keep its attitude meanwhile.
ImageMotion expected_image_motion(std::int64_t timestamp_ns, const Component::State& s);

}  // namespace polhode
