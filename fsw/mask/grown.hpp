// A rectangle with a margin around it, or in larger pixels.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

inline cv::Rect grown(const cv::Rect& box, int by) {
  return {box.x - by, box.y - by, box.width + 2 * by, box.height + 2 * by};
}

/// The smallest rectangle that contains another one, in pixels that are `step` of its own along a
/// side.
inline cv::Rect coarser(const cv::Rect& box, int step) {
  return {cv::Point(box.x / step, box.y / step),
          cv::Point((box.br().x + step - 1) / step, (box.br().y + step - 1) / step)};
}

}  // namespace polhode
