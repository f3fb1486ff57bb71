// From log-odds to an outline: finds the piece of the image that is the target.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

/// Log-odds over this count as target, in sigmas a pixel. The mean over a window of 25 pixels with
/// independent noise of one sigma scatters by 0.2: this is 1.5 sigma of it.
inline constexpr float kTargetLogOdds = 0.3F;

/// Error of outlines, in working pixels. With 2, fewer landmarks are on the background, and
/// attitudes are worse: 0.56 instead of 0.42 deg on small `paper_2d` (decision 0015).
inline constexpr int kOutlineOff_px = 4;

/// Area of the smallest target's box, in working pixels: 10 x 10. Chosen; a smaller one supports no
/// map.
inline constexpr int kTargetAreaMin = 100;

/// Working memory; contents mean nothing between calls.
struct OutlineScratch {
  cv::Mat positive, labels, stats, centroids, flooded;
};

struct OutlineInput {
  cv::Mat log_odds;  ///< CV_32FC1
  cv::Mat seeds;     ///< CV_8UC1 or empty: target whatever the log-odds
  cv::Rect region;   ///< outside of it the log-odds are 0
  cv::Mat closing;   ///< CV_8UC1, of odd sides: structuring element that closes gaps
  int step = 1;      ///< working pixels per pixel of all of these, along a side
};

/// The piece with the largest sum of log-odds, and pieces close to it: closed, holes filled.
/// @param outline CV_8UC1, 255 on the target; all 0 without a piece large enough.
/// @return false when there is none.
bool find_outline(const OutlineInput& input, OutlineScratch* scratch, cv::Mat* outline);

}  // namespace polhode
