// Reduces and enlarges images.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// Means over squares of `by` x `by` pixels, by halves: OpenCV has a fast loop for two, which takes
/// an eighth of the time of one step by four.
/// @param image  CV_8UC1 [about size * by]
/// @param by       a power of two
/// @param out      CV_8UC1 [size]
void shrink(const cv::Mat& image, const cv::Size& size, int by, cv::Mat* out);

/// Sets the pixels of another size of which half is covered.
/// @param set  CV_8UC1 of 0 and 255
/// @param out  CV_8UC1 [size], the same; may be `set`
void cover_by_half(const cv::Mat& set, const cv::Size& size, cv::Mat* out);

/// Enlarges the cells that a box overlaps.
/// @param cells  CV_8UC1, of `step` pixels along a side
/// @param step   1 or 2
/// @param out    CV_8UC1; outside of these cells nothing is written
void fill_from_cells(const cv::Mat& cells, int step, const cv::Rect& box, cv::Mat* out);

}  // namespace polhode
