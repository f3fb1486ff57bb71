// Following points over small image motion: pyramidal Lucas-Kanade with a forward-backward check.
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>
#include <vector>

#include "tracks/options.hpp"

namespace polhode {

/// An image and its halves, as the flow needs them.
struct Pyramid {
  std::vector<cv::Mat> levels;
  bool built = false;  ///< of the picture that it belongs to; else the levels are only memory
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
/// @source Bouguet 2000, by way of OpenCV; forward-backward: Kalal, Mikolajczyk, Matas, ICPR 2010.
void follow_points(const Pyramid& before,
                   const Pyramid& now,
                   std::span<const FlowPoint> from,
                   const TrackOptions& options,
                   std::span<FlowPoint> guess);

}  // namespace polhode
