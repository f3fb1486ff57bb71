// An outline's last pixels: where the picture has its edges.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// How far an outline may be moved, in the picture's pixels, and by how many of them at a time.
struct CutReach {
  int px;
  int cell_px = 1;  ///< 2: a far cut in an eighth of the time, for a near one to follow
};

/// Moves the outline to the edges of the picture nearby: the least cut between target and the rest,
/// dear where the picture is even. For keyframes.
/// @param opinion CV_32FC1: for (positive) or against target, pixel by pixel; 6 equals an even
/// place. Far weaker, it says on which side of an edge the target is, and the edges say where.
/// @param certain CV_8UC1 or empty: target whatever the opinion.
/// @param outline CV_8UC1, 255 on the target.
/// @cost one maximum flow over the cells that the outline may be moved over: more than in proportion to them.
/// @source Boykov and Kolmogorov, PAMI 2004, by way of OpenCV; from coarse to fine as Lombaert et al., ICCV 2005.
void cut_at_edges(const cv::Mat& picture,
                  const cv::Mat& opinion,
                  const cv::Mat& certain,
                  const CutReach& reach,
                  cv::Mat* outline);

}  // namespace polhode
