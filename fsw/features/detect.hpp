// Features: sub-pixel blobs with rotation-invariant descriptors, spread over the target.
#pragma once

#include <opencv2/core/mat.hpp>

#include "features/feature.hpp"
#include "features/options.hpp"
#include "geometry/camera_model.hpp"
#include "mask/target_mask.hpp"

namespace polhode {

struct FeatureWorkspace;  // features/workspace.hpp

/// Gray levels of 8 bits, and where they are the target's. Pointers are never null.
struct MaskedImage {
  const cv::Mat* gray = nullptr;
  const TargetMask* mask = nullptr;
};

/// Detects in the mask's region, resampled to the working size (at most three times its own), and
/// keeps at most count_max by strength with an even share for each cell of a grid over the region.
/// No heap.
/// @cost  linear in working pixels and in features.
/// @source Lowe, IJCV 2004.
void detect_features(const MaskedImage& image,
                     const CameraModel& camera,
                     const FeatureOptions& options,
                     FeatureWorkspace* workspace,
                     Features* features);

}  // namespace polhode
