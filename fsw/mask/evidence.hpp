// Pixel by pixel, with a map by cells of some: does the picture move like the background, or like
// the target's points?
//
// Each place of the newest picture is compared with where the background's motion and where the
// target's would have brought it from. What one of the two explains and the other does not is told
// apart to a pixel or two, from the second picture on; what both explain, an even place, or
// neither, one that has just come into view, says nothing.
#pragma once

#include "mask/background.hpp"
#include "mask/origins.hpp"

namespace polhode {

struct EvidenceState {
  static constexpr float kMax = 6.0F;

  cv::Mat total;       ///< CV_32FC1: positive where the target is; carried along with its motion
  int step = 1;        ///< working pixels a pixel of it, along a side
  bool longer = true;  ///< the next picture is compared over the longer of the two ages
  cv::Rect region;     ///< in which the last pictures were compared, working pixels
  double noise = 2.0;  ///< one sigma of a working pixel, levels

  // Scratch; contents mean nothing between calls.
  cv::Mat warped, seen, low, high, bounds, excess, least, difference, sum, from, carried, before,
      covered;
  cv::Mat flow, flow_far, weight, weight_far;
  Origins origins;
};

/// Evidence for a picture of this size, by so many of its pixels. What is known stays, coarser or
/// finer.
void size_evidence(const cv::Size& picture, int step, EvidenceState* state);

/// Compares the newest picture with earlier ones within a region and adds to the evidence. What was
/// known outside of it is forgotten. Needs points of both kinds, and evidence of the picture's
/// size.
/// @cost in proportion to the region: as many look-ups of its pixels as there are layers, and one
/// more.
void weigh_motions(const PointsState& points,
                   const BackgroundState& background,
                   const cv::Rect& region,
                   EvidenceState* state);

/// An outline (CV_8UC1 of the picture's size) that edges and looks have decided: what it holds is
/// taken along as evidence, what it leaves out is no longer.
void remember_outline(const cv::Mat& outline, EvidenceState* state);

void clear(EvidenceState* state);

}  // namespace polhode
