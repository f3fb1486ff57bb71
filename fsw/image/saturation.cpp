#include "image/saturation.hpp"

#include <algorithm>
#include <cmath>

namespace polhode {

bool near_saturated(const cv::Mat& gray, double u_px, double v_px, double saturated_level) {
  constexpr int kAround_px = 3;
  const double level = saturated_level * 255.0;
  const int u = static_cast<int>(std::lround(u_px));
  const int v = static_cast<int>(std::lround(v_px));
  for (int row = std::max(0, v - kAround_px); row <= std::min(gray.rows - 1, v + kAround_px);
       ++row) {
    const std::uint8_t* pixel = gray.ptr<std::uint8_t>(row);
    for (int column = std::max(0, u - kAround_px);
         column <= std::min(gray.cols - 1, u + kAround_px);
         ++column) {
      if (pixel[column] >= level) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace polhode
