// Is something behind the target, or black space?
#pragma once

#include <opencv2/core.hpp>

#include "mask/outline.hpp"

namespace polhode {

/// Is some of the image border lit? Otherwise is_behind() is false for any body.
/// @param cells CV_8UC1, not 0 where the image is lit.
bool border_is_lit(const cv::Mat& cells);

/// Is enough of the image border lit for something to be behind the target, unless a known body
/// reaches it?
/// @param cells as above
bool border_is_full(const cv::Mat& cells);

/// Is something behind the target? Two fifths of the image border are lit, or a corner of it, apart
/// from the target.
/// @param cells CV_8UC1, not 0 where the image is lit.
/// @param body cells that a known body reaches: they do not count. May be empty.
/// @param was_behind the result for the image before: then less of the border is enough.
bool is_behind(const cv::Mat& cells,
               const cv::Rect& body,
               bool was_behind,
               OutlineScratch* scratch);

}  // namespace polhode
