// Adds an optional network's answer to the unary cost.
#pragma once

#include <opencv2/core/mat.hpp>

#include "mask/network.hpp"

namespace polhode {

/// Working memory; contents mean nothing between calls.
struct RefineScratch {
  cv::Mat part, gray, outline, target, full;
};

/// Shows the network the outline's box, grown by a quarter, and adds its answer to the unary cost.
/// An answer that is not a probability everywhere is ignored.
/// @param picture, outline CV_8UC1. @param step pixels of both per pixel of the unary cost, along a
/// side.
/// @param unary_cost CV_32FC1: for (positive) or against target.
void refine_unary_cost(const cv::Mat& picture,
                       const cv::Mat& outline,
                       const MaskNetwork& network,
                       int step,
                       RefineScratch* scratch,
                       cv::Mat* unary_cost);

}  // namespace polhode
