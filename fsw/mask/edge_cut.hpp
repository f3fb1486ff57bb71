// Moves an outline to image edges, over its last pixels.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// Range and resolution of a cut, in the image's pixels.
struct CutReach {
  int px;
  int cell_px = 1;  ///< 2: coarse, an eighth of the time; a fine cut follows
};

/// Unary cost of the graph cut.
struct UnaryCost {
  const cv::Mat& value;  ///< CV_32FC1: of calling a cell background; negative: of calling it
                         ///< target. An even place along the side of a cell's pixel costs 6.
  const cv::Mat& seeds;  ///< CV_8UC1 or empty: target whatever the value
  int cell_px = 1;       ///< 1 or 2: the image's pixels per cell, along a side
};

/// A part of an image and the steps between its pixels.
struct ImageEdges {
  cv::Rect box;                   ///< starts and ends with a cell of two pixels, or with the image
  cv::Mat left, up;               ///< CV_8UC1 of the box: step to the neighbour, levels
  double mean_square_step = 1.0;  ///< both directions together
};

void measure_edges(const cv::Mat& image, const cv::Rect& box, ImageEdges* edges);

/// Moves the outline to image edges nearby, by a graph cut: the cheapest boundary between target
/// and the rest, expensive where the image is even. For keyframes. Outside of the edges' box
/// nothing changes.
/// @param unary_cost far smaller than the boundary cost of an even place: it decides on which side
/// of an edge the target is; the edges decide where the boundary runs.
/// @param reach by pixels, or by the unary cost's cells.
/// @param outline CV_8UC1, 255 on the target.
/// @cost one maximum flow over the cells within reach of the outline: more than in proportion to
/// them.
/// @source Boykov and Kolmogorov, PAMI 2004, by way of OpenCV; from coarse to fine as Lombaert et
/// al., ICCV 2005.
void cut_at_edges(const ImageEdges& edges,
                  const UnaryCost& unary_cost,
                  const CutReach& reach,
                  cv::Mat* outline);

}  // namespace polhode
