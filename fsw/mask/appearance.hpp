// What a place looks like: gray level and roughness, as the target has them and what is beside it.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// Working memory; contents mean nothing between calls.
struct AppearanceScratch {
  cv::Mat looks, one, other;
};

/// Adds to an opinion what looks speak for: how often a place like this is within the outline,
/// against how often around it, or against certainty where the background is known to look like
/// this in that very place, as a logarithm. An even place fits the background's motion and the
/// target's, and motion says nothing of it; the dark cell of a panel before a bright Earth says
/// what it is by being dark. Nothing is added where either has under a few hundred pixels.
/// @param picture CV_8UC1. @param outline CV_8UC1, same size.
/// @param matches CV_8UC1, same size, 255 where the picture looks as the background there is known
/// to look.
/// @param region outside of it nothing is added.
/// @param step pixels of the picture per pixel of the opinion, along a side.
/// @param opinion CV_32FC1, as cut_at_edges takes it.
/// @cost eight passes over the outline's box and a third of its width around, where looks are
/// compared, and one over the region.
/// @source the colour term of Rother, Kolmogorov, Blake, "GrabCut", SIGGRAPH 2004, as a histogram
/// of gray.
void add_appearance(const cv::Mat& picture,
                    const cv::Mat& outline,
                    const cv::Mat& matches,
                    const cv::Rect& region,
                    int step,
                    AppearanceScratch* scratch,
                    cv::Mat* opinion);

}  // namespace polhode
