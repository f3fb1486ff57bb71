// Features of a rolling shutter, each seen at its row's time.
#pragma once

#include "features/feature.hpp"
#include "geometry/image_motion.hpp"

namespace polhode {

/// Brings the normalised points, from the pixels, to the frame's time. Pixels stay as they were
/// seen. Features of a camera without row times stay as they are.
void to_frame_time(const CameraModel& camera, const ImageMotion& motion, Features* features);

}  // namespace polhode
