// Which pixel of an earlier picture each pixel of a region was, and what was there; what was known
// there, carried along.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// Whole pixels of the earlier picture, the nearest ones.
struct Origins {
  cv::Mat index;  ///< CV_32SC1: of the pixel, row by row

  cv::Mat flow;  ///< scratch
};

/// @param motion  homography from the earlier picture to this one
/// @param region  pixels of this picture
/// @param before_size  of the earlier picture: what is from outside of it is from its rim
void trace_plane(const cv::Matx33d& motion,
                 const cv::Rect& region,
                 const cv::Size& before_size,
                 Origins* origins);

/// @param flow  CV_32FC2: how far this picture's pixels have come, by cells of a grid
/// @param region  pixels of this picture, from the corner of a cell on
/// @param before_size  as above
void trace_flow(const cv::Mat& flow,
                int cell_px,
                const cv::Rect& region,
                const cv::Size& before_size,
                Origins* origins);

/// What was there. @param before  continuous, CV_16UC1. @param out  as many pixels as there are
/// origins.
void look_up(const cv::Mat& before, const Origins& origins, cv::Mat* out);

/// What was kept of an earlier picture, by cells, where the flow has brought it: between cells by
/// interpolation, outside of it the rim.
/// @param flow, region  as above
/// @param step  pixels a cell of `before` and of `out`, along a side: a divisor of `cell_px`
/// @param from  scratch
/// @param out   the region, by cells
void carry(const cv::Mat& flow,
           int cell_px,
           const cv::Rect& region,
           int step,
           const cv::Mat& before,
           cv::Mat* from,
           cv::Mat* out);

}  // namespace polhode
