// Is something behind the target, or black space?
#pragma once

#include <opencv2/core.hpp>

#include "mask/outline.hpp"

namespace polhode {

/// Is some of the image border lit? Otherwise is_behind() is false for any body.
/// @param cells CV_8UC1, not 0 where the image is lit.
bool border_is_lit(const cv::Mat& cells);

/// Are two fifths of the image border lit? Something is then behind the target, unless a known body
/// extends to the border and is what is lit there.
/// @param cells as above
bool border_is_full(const cv::Mat& cells);

/// Is something behind the target? Yes where two fifths of the image border are lit, or where a lit
/// piece other than the target covers a corner and 0.15 of the border.
/// @param cells CV_8UC1, not 0 where the image is lit.
/// @param body cells that a known body can extend to: they do not count. May be empty.
/// @param was_behind the result for the image before. If true, less of the border is enough.
bool is_behind(const cv::Mat& cells,
               const cv::Rect& body,
               bool was_behind,
               OutlineScratch* scratch);

}  // namespace polhode
