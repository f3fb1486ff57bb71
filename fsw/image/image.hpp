// The frame for all other stages: 8-bit gray.
#pragma once

#include <opencv2/core/mat.hpp>

#include "base/image_view.hpp"

namespace polhode {

/// Copies the camera's frame into `gray` (CV_8UC1, allocated once). 16-bit pixels keep their upper
/// byte.
void import_frame(const ImageView& frame, cv::Mat* gray);

}  // namespace polhode
