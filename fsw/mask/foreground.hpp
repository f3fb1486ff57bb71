// Foreground log-odds: does a place move like the background, or like the target's points?
// Compares each place of the newest image with its origins by the background's motion and by the
// target's. A place that only one of the two explains counts, to a pixel or two, from the second
// image on. A place that both explain (an even one) or neither (just come into view) does not.
#pragma once

#include "mask/background.hpp"
#include "mask/origins.hpp"

namespace polhode {

/// Motion of the target on a grid of cells, and how many points each cell's rests on.
struct TargetFlow {
  cv::Mat flow, flow_far, weight, weight_far;
};

/// Working memory; contents mean nothing between calls.
struct ForegroundScratch {
  cv::Mat warped, visible, low, high, bounds, excess, least, difference, sum, from, carried, before,
      covered;
  TargetFlow target;
  Origins origins;
};

struct ForegroundState {
  // Bound on the log-odds: comparisons add at most 2 an image, of which 0.55 stays, so 4.4 in the
  // end.
  static constexpr float kLogOddsMax = 6.0F;
  // A camera's noise before it is measured, levels. Chosen; it follows the measurement of the first
  // images.
  static constexpr double kNoiseFirst = 2.0;

  cv::Mat log_odds;    ///< CV_32FC1: positive on the target, in sigmas a pixel; moved along with
                       ///< the target
  int step = 1;        ///< working pixels per pixel of it, along a side
  bool longer = true;  ///< the next image is compared over the longer of the two ages
  cv::Rect region;     ///< in which the last images were compared, working pixels
  double noise = kNoiseFirst;  ///< one sigma of a working pixel, levels
  ForegroundScratch scratch;
};

/// Resizes the log-odds for an image of this size, to cells of `step` of its pixels. Their content
/// stays, coarser or finer.
void resize_log_odds(const cv::Size& image, int step, ForegroundState* state);

/// Compares the newest image with an earlier one within a region and adds to the log-odds. Outside
/// of the region they become 0. Needs points of both classes, and log-odds of the image's size.
/// @cost in proportion to the region: one look-up of its pixels for each layer, and one more.
void update_log_odds(const PointsState& points,
                     const BackgroundState& background,
                     const cv::Rect& region,
                     ForegroundState* state);

/// Stores an outline (CV_8UC1 of the image's size) that a graph cut has decided: its inside becomes
/// foreground in the log-odds, its outside does not stay foreground.
void remember_outline(const cv::Mat& outline, ForegroundState* state);

void clear(ForegroundState* state);

}  // namespace polhode
