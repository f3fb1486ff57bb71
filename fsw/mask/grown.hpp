// A rectangle with a margin about it.
#pragma once

#include <opencv2/core.hpp>

namespace polhode {

inline cv::Rect grown(const cv::Rect& box, int by) {
  return {box.x - by, box.y - by, box.width + 2 * by, box.height + 2 * by};
}

}  // namespace polhode
