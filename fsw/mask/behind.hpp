// Is something behind the target, or black space?
#pragma once

#include <opencv2/core.hpp>

#include "mask/outline.hpp"

namespace polhode {

/// May something be behind the target? Not where is_behind says no whatever body it is told of.
/// @param cells CV_8UC1, not 0 where the picture is lit.
bool rim_is_lit(const cv::Mat& cells);

/// Is so much of the picture's rim lit that something is behind the target, unless a known body is
/// what is there?
/// @param cells as above
bool rim_is_full(const cv::Mat& cells);

/// Is something behind the target? Two fifths of the picture's rim are lit, or a corner of it by
/// what is apart from the target.
/// @param cells CV_8UC1, not 0 where the picture is lit.
/// @param body cells that a known body reaches: they do not count. May be empty.
/// @param was_behind it was in the picture before: then little is enough.
bool is_behind(const cv::Mat& cells,
               const cv::Rect& body,
               bool was_behind,
               OutlineScratch* scratch);

}  // namespace polhode
