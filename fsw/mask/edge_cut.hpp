// An outline's last pixels: where the picture has its edges.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// How far an outline may be moved, in the picture's pixels, and by how many of them at a time.
struct CutReach {
  int px;
  int cell_px = 1;  ///< 2: a far cut in an eighth of the time, for a near one to follow
};

/// What is thought of each cell of the picture before its edges are asked.
struct CutOpinion {
  const cv::Mat& weight;   ///< CV_32FC1: for (positive) or against target; 6 equals an even place
                           ///< along the side of a cell's pixel
  const cv::Mat& certain;  ///< CV_8UC1 or empty: target whatever the weight
  int cell_px = 1;         ///< 1 or 2: the picture's pixels per cell, along a side
};

/// A part of a picture and the steps between its pixels.
struct PictureEdges {
  cv::Rect box;      ///< starts and ends with a cell of two pixels, or with the picture
  cv::Mat left, up;  ///< CV_8UC1 of the box: step to the neighbour, levels
  double mean_square_step = 1.0;  ///< both directions together
};

void measure_edges(const cv::Mat& picture, const cv::Rect& box, PictureEdges* edges);

/// Moves the outline to the edges of the picture nearby: the least cut between target and the rest,
/// dear where the picture is even. For keyframes. What is outside of the edges' box stays as it is.
/// @param opinion Far weaker than an even place, it says on which side of an edge the target is,
/// and the edges say where.
/// @param reach by pixels, or by the opinion's cells.
/// @param outline CV_8UC1, 255 on the target.
/// @cost one maximum flow over the cells that the outline may be moved over: more than in
/// proportion to them.
/// @source Boykov and Kolmogorov, PAMI 2004, by way of OpenCV; from coarse to fine as Lombaert et
/// al., ICCV 2005.
void cut_at_edges(const PictureEdges& edges,
                  const CutOpinion& opinion,
                  const CutReach& reach,
                  cv::Mat* outline);

}  // namespace polhode
