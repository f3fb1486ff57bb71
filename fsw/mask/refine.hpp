// The network's word, where there is a network, on where the target is.
#pragma once

#include <opencv2/core/mat.hpp>

#include "mask/network.hpp"

namespace polhode {

/// Working memory; contents mean nothing between calls.
struct RefineScratch {
  cv::Mat part, gray, outline, target, full;
};

/// Shows the network the outline's box, grown by a quarter, and adds what it says to the opinion.
/// An opinion that is not finite is none.
/// @param picture, outline CV_8UC1. @param step pixels of both per pixel of the opinion, along a
/// side.
/// @param opinion CV_32FC1: for (positive) or against target.
void refine_opinion(const cv::Mat& picture,
                    const cv::Mat& outline,
                    const MaskNetwork& network,
                    int step,
                    RefineScratch* scratch,
                    cv::Mat* opinion);

}  // namespace polhode
