// The target's pixels by level, for the exposure controller.
#pragma once

#include <opencv2/core/mat.hpp>

#include "image/exposure.hpp"
#include "mask/target_mask.hpp"

namespace polhode {

/// Empty space in the mask's margin is left out: what is at or under the mask's dark level.
LevelCounts target_levels(const cv::Mat& gray, const MaskOptions& options, const TargetMask& mask);

}  // namespace polhode
