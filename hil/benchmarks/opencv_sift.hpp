// OpenCV's SIFT behind the interface of fsw/features: the reference that own code is measured
// against.
#pragma once

#include "features/detect.hpp"

namespace polhode::benchmark {

void detect_features_opencv(const cv::Mat& gray,
                            const TargetMask& mask,
                            const CameraModel& camera,
                            const FeatureOptions& options,
                            Features* features);

}  // namespace polhode::benchmark
