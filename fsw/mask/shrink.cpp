#include "mask/shrink.hpp"

#include <opencv2/imgproc.hpp>

namespace polhode {

void shrink(const cv::Mat& picture, const cv::Size& size, int by, cv::Mat* out) {
  cv::Mat halved = picture;
  for (int left = by / 2; left > 1; left /= 2) {
    cv::Mat half;
    cv::resize(halved, half, size * left, 0.0, 0.0, cv::INTER_AREA);
    halved = half;
  }
  cv::resize(halved, *out, size, 0.0, 0.0, cv::INTER_AREA);
}

}  // namespace polhode
