// A picture made smaller by a power of two.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// Means over squares of `by` x `by` pixels, by halves: OpenCV has a fast loop for two, which takes an eighth of the time
/// of one step by four.
/// @param picture  CV_8UC1 [about size * by]
/// @param by       a power of two
/// @param out      CV_8UC1 [size]
void shrink(const cv::Mat& picture, const cv::Size& size, int by, cv::Mat* out);

}  // namespace polhode
