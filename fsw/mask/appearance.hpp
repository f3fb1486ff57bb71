// Appearance model: gray level and roughness, of the target and of its surroundings.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// Working memory; contents mean nothing between calls.
struct AppearanceScratch {
  cv::Mat appearances, one, other;
};

struct AppearanceInput {
  cv::Mat image;    ///< CV_8UC1
  cv::Mat outline;  ///< CV_8UC1, same size
  cv::Mat matches;  ///< CV_8UC1, same size, 255 where the image agrees with the known background
  cv::Rect region;  ///< outside of it nothing is added
  int step = 1;     ///< pixels of the image per pixel of the unary cost, along a side
};

/// Adds the appearance to a unary cost: the log ratio of its frequencies within the outline and
/// around it. Where the pixel agrees with the known background, the frequency around it is taken as
/// one. An even place agrees with both motions, so only its appearance separates it, as a panel's
/// dark cell before a bright Earth. Adds nothing where inside or outside has under a few hundred
/// pixels.
/// @param unary_cost CV_32FC1, as cut_at_edges takes it.
/// @cost eight passes over the outline's box and a third of its width around, where appearances are
/// compared, and one over the region.
/// @source the colour term of Rother, Kolmogorov, Blake, "GrabCut", SIGGRAPH 2004, as a histogram
/// of gray.
void add_appearance(const AppearanceInput& input, AppearanceScratch* scratch, cv::Mat* unary_cost);

}  // namespace polhode
