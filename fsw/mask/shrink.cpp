#include "mask/shrink.hpp"

#include <opencv2/imgproc.hpp>

#include "base/assert.hpp"

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

void cover_by_half(const cv::Mat& set, const cv::Size& size, cv::Mat* out) {
  cv::resize(set, *out, size, 0.0, 0.0, cv::INTER_AREA);
  cv::threshold(*out, *out, 127.0, 255.0, cv::THRESH_BINARY);
}

void fill_from_cells(const cv::Mat& cells, int step, const cv::Rect& box, cv::Mat* out) {
  POLHODE_ASSERT(step == 1 || step == 2, step);
  cv::Mat part = (*out)(box);
  if (step == 1) {
    cells(box).copyTo(part);
    return;
  }
  for (int row = 0; row < part.rows; ++row) {
    const auto* from = cells.ptr<std::uint8_t>((box.y + row) / 2);
    auto* to = part.ptr<std::uint8_t>(row);
    for (int column = 0; column < part.cols; ++column) {
      to[column] = from[(box.x + column) >> 1];
    }
  }
}

}  // namespace polhode
