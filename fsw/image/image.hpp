// The frame as the other stages see it: 8-bit gray, with its quality.
#pragma once

#include <opencv2/core/mat.hpp>

#include "base/image_view.hpp"
#include "image/options.hpp"

namespace polhode {

struct ImageQuality {
  double bright_level = 0.0;  ///< level that 0.1 % of the pixels exceed, fraction of full scale
  double saturated_fraction = 0.0;  ///< pixels at or over the saturated level
  bool dark = false;                ///< nothing to see
};

/// Copies the camera's frame into `gray` (CV_8UC1, allocated once); 16-bit pixels keep their upper
/// octet.
void import_frame(const ImageView& frame, cv::Mat* gray);

/// One pass over the histogram.
ImageQuality assess(const cv::Mat& gray, const ImageOptions& options);

}  // namespace polhode
