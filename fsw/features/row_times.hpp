// Row times of a rolling shutter: brings each feature from its row's time to the frame's.
#pragma once

#include "features/feature.hpp"
#include "geometry/image_motion.hpp"

namespace polhode {

/// Recomputes the normalised points at the frame's time, from the pixels. Pixels stay as detected.
/// Without row times nothing changes.
void to_frame_time(const CameraModel& camera, const ImageMotion& motion, Features* features);

}  // namespace polhode
