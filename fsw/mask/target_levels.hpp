// The target's pixels by level, for the exposure controller.
#pragma once

#include <opencv2/core/mat.hpp>

#include "image/exposure.hpp"
#include "mask/target_mask.hpp"

namespace polhode {

/// Leaves out what is at or under the mask's dark level: empty space in the mask's margin.
LevelCounts target_levels(const cv::Mat& gray, const MaskOptions& options, const TargetMask& mask);

}  // namespace polhode
