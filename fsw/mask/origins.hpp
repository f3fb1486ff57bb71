// Source pixels of a region in an earlier image, and look-up of values there.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// Source pixels in the earlier image, rounded to whole ones.
struct Origins {
  cv::Mat index;  ///< CV_32SC1: of the pixel, row by row

  cv::Mat flow;  ///< scratch
};

/// @param motion  homography from the earlier image to this one
/// @param region  pixels of this image
/// @param before_size  of the earlier image: an origin outside of it is taken at its border
void trace_plane(const cv::Matx33d& motion,
                 const cv::Rect& region,
                 const cv::Size& before_size,
                 Origins* origins);

/// @param flow  CV_32FC2: displacement of this image's pixels since the earlier one, by cells of a
/// grid
/// @param region  pixels of this image, from the corner of a cell on
/// @param before_size  as above
void trace_flow(const cv::Mat& flow,
                int cell_px,
                const cv::Rect& region,
                const cv::Size& before_size,
                Origins* origins);

/// Looks up the values at the origins.
/// @param before  continuous, CV_16UC1.
/// @param out  of the size of the origins.
void look_up(const cv::Mat& before, const Origins& origins, cv::Mat* out);

/// A region of this image, by cells.
struct CarriedRegion {
  cv::Rect region;  ///< from the corner of a cell of the flow on
  int step = 1;     ///< pixels per cell, along a side: a divisor of flow_cell_px
  int flow_cell_px = 1;
};

/// Moves values of an earlier image, by cells, along the flow. Between cells by interpolation;
/// outside of it the border is repeated.
/// @param flow    as above
/// @param before  by cells like those of `out`
/// @param from    scratch
/// @param out     the region
void carry(const cv::Mat& flow,
           const CarriedRegion& to,
           const cv::Mat& before,
           cv::Mat* from,
           cv::Mat* out);

}  // namespace polhode
