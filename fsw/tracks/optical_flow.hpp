// Tracks points over small image motion: pyramidal Lucas-Kanade with a forward-backward check.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "tracks/options.hpp"

namespace polhode {

/// An image and its halved copies, with gradients, as optical flow needs them.
struct Pyramid {
  std::vector<cv::Mat> levels;
  bool built = false;  ///< for the image that it belongs to; otherwise the levels are memory only
};

void build_pyramid(const cv::Mat& gray, Pyramid* pyramid);

struct FlowPoint {
  float u_px = 0.0F;
  float v_px = 0.0F;
  bool followed = false;
};

/// @param from   points in the image of `before`.
/// @param guess  in: where they are expected in `now`; out: where they are, `followed` false where
/// lost.
/// @source Bouguet 2000, via OpenCV; forward-backward: Kalal, Mikolajczyk, Matas, ICPR 2010.
void follow_points(const Pyramid& before,
                   const Pyramid& now,
                   std::span<const FlowPoint> from,
                   const TrackOptions& options,
                   std::span<FlowPoint> guess);

}  // namespace polhode
