// From evidence to an outline: the one piece of the picture that is the target.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// Outlines are off by so much, in working pixels.
inline constexpr int kOutlineOff_px = 4;

/// The box of a target that carries a map holds as many working pixels.
inline constexpr int kTargetAreaMin = 100;

/// Working memory; contents mean nothing between calls.
struct OutlineScratch {
  cv::Mat positive, labels, stats, centroids, flooded;
};

/// The piece with the most evidence, and what lies close to it: closed, its holes filled.
/// @param evidence CV_32FC1. @param certain CV_8UC1 or empty: target whatever the evidence.
/// @param region outside of it there is no evidence. @param closing CV_8UC1, of odd sides: gaps
/// that it does not fit into are closed.
/// @param step working pixels a pixel of all of these, along a side.
/// @param outline CV_8UC1, 255 on the target; all 0 when there is no piece worth a target.
/// @return false when there is none.
bool find_outline(const cv::Mat& evidence,
                  const cv::Mat& certain,
                  const cv::Rect& region,
                  const cv::Mat& closing,
                  int step,
                  OutlineScratch* scratch,
                  cv::Mat* outline);

}  // namespace polhode
