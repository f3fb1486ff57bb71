// Gray level of the background in each place, where the camera stands still.
// A running median over time without the target. A median over all images would be the target's
// level where it covers a place for half of the time (decision 0014).
#pragma once

#include <opencv2/core.hpp>

#include "mask/background.hpp"

namespace polhode {

struct BackgroundModel {
  cv::Mat level;    ///< CV_8UC1: median gray level
  cv::Mat votes;    ///< CV_8UC1: images that agreed with it, less those that did not; 0: unknown
  cv::Mat matches;  ///< CV_8UC1, by match_background: 255 where that image agrees with the known
                    ///< background in that very place
};

/// Does one of the background's motions leave the image in place?
bool stands_still(const BackgroundState& background, const cv::Size& size);

/// Updates the background model outside of the target's outline, beyond the outline's error.
/// Overwrites `matches`.
/// @param noise one sigma of a pixel, levels.
/// @cost one dilation and one pass over the image.
void learn_background(const cv::Mat& image,
                      const cv::Mat& outline,
                      double noise,
                      BackgroundModel* model);

/// Fills `matches`; leaves it zero while the model is empty.
void match_background(const cv::Mat& image, double noise, BackgroundModel* model);

void clear(BackgroundModel* model);

}  // namespace polhode
