// What the background looks like, place by place, where the camera stands still.
//
// A median over time that only takes in what is not the target: one over all pictures would need
// the target to leave each place for half of the time.
#pragma once

#include <opencv2/core.hpp>

#include "mask/background.hpp"

namespace polhode {

struct BackgroundModel {
  cv::Mat level;    ///< CV_8UC1: a place's median gray level
  cv::Mat votes;    ///< CV_8UC1: pictures in which it looked so, less those in which it did not; 0:
                    ///< nothing is known
  cv::Mat matches;  ///< CV_8UC1, by match_background: 255 where that picture looks as the
                    ///< background is known to look in that very place
};

/// Does one of the background's motions leave the picture where it was?
bool stands_still(const BackgroundState& background, const cv::Size& size);

/// Takes in what lies outside of the target's outline by more than outlines are off. `matches`
/// means nothing after it.
/// @param noise one sigma of a pixel, levels.
/// @cost one dilation and one pass over the picture.
void learn_background(const cv::Mat& picture,
                      const cv::Mat& outline,
                      double noise,
                      BackgroundModel* model);

/// Fills `matches`: nothing, while nothing is known.
void match_background(const cv::Mat& picture, double noise, BackgroundModel* model);

void clear(BackgroundModel* model);

}  // namespace polhode
