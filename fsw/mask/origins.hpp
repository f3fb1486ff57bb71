// Where each pixel of a region was in an earlier picture, and what was there.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// In thirty-seconds of a pixel, as cv::remap takes it.
struct Origins {
  cv::Mat pixel;     ///< CV_16SC2
  cv::Mat fraction;  ///< CV_16UC1

  cv::Mat flow;  ///< scratch
};

/// @param motion  homography from the earlier picture to this one
/// @param region  pixels of this picture
/// @param before_size  of the earlier picture: what is from farther outside of it is from its rim
void trace_plane(const cv::Matx33d& motion, const cv::Rect& region, const cv::Size& before_size, Origins* origins);

/// @param flow    CV_32FC2: how far this picture's pixels have come, by cells of a grid
/// @param cell_px pixels a cell, along a side
/// @param region  starts with a cell
/// @param step    pixels of the picture per pixel of the origins and of what they are in, along a side
/// @param before_size  of what they are in
void trace_flow(const cv::Mat& flow,
                int cell_px,
                const cv::Rect& region,
                int step,
                const cv::Size& before_size,
                Origins* origins);

/// What was there, between pixels by interpolation. @param out as many pixels as there are origins.
void look_up(const cv::Mat& before, const Origins& origins, cv::Mat* out);

}  // namespace polhode
