// Appearance model: gray level and roughness, of the target and of what is beside it.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// Working memory; contents mean nothing between calls.
struct AppearanceScratch {
  cv::Mat appearances, one, other;
};

/// Adds the appearance to a unary cost: the logarithm of how frequent a place's appearance is
/// within the outline against around it. Against one where the background in that very place is
/// known to look like this. An even place fits both motions, and only its appearance separates it:
/// a panel's dark cell before a bright Earth. Adds nothing where inside or outside has under a few
/// hundred pixels.
/// @param image CV_8UC1. @param outline CV_8UC1, same size.
/// @param matches CV_8UC1, same size, 255 where the image agrees with the known background.
/// @param region outside of it nothing is added.
/// @param step pixels of the image per pixel of the unary cost, along a side.
/// @param unary_cost CV_32FC1, as cut_at_edges takes it.
/// @cost eight passes over the outline's box and a third of its width around, where appearances are
/// compared, and one over the region.
/// @source the colour term of Rother, Kolmogorov, Blake, "GrabCut", SIGGRAPH 2004, as a histogram
/// of gray.
void add_appearance(const cv::Mat& image,
                    const cv::Mat& outline,
                    const cv::Mat& matches,
                    const cv::Rect& region,
                    int step,
                    AppearanceScratch* scratch,
                    cv::Mat* unary_cost);

}  // namespace polhode
