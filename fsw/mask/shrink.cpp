#include "mask/shrink.hpp"

#include <algorithm>
#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "base/assert.hpp"
#include "mask/grown.hpp"

namespace polhode {

void shrink(const cv::Mat& image, const cv::Size& size, int by, cv::Mat* out) {
  cv::Mat halved = image;
  for (int left = by / 2; left > 1; left /= 2) {
    cv::Mat half;
    cv::resize(halved, half, size * left, 0.0, 0.0, cv::INTER_AREA);
    halved = half;
  }
  cv::resize(halved, *out, size, 0.0, 0.0, cv::INTER_AREA);
}

void cover_by_half(const cv::Mat& set, const cv::Size& size, cv::Mat* out) {
  constexpr double kHalf = 127.0;  // a larger mean is 128 of 255 or more
  cv::resize(set, *out, size, 0.0, 0.0, cv::INTER_AREA);
  cv::threshold(*out, *out, kHalf, 255.0, cv::THRESH_BINARY);
}

void fill_from_cells(const cv::Mat& cells, int step, const cv::Rect& box, cv::Mat* out) {
  POLHODE_ASSERT(step == 1 || step == 2, step);
  if (step == 1) {
    cv::Mat part = (*out)(box);  // may be empty
    cells(box).copyTo(part);
    return;
  }
  const cv::Rect part = coarser(box, 2);
  const int columns = std::min(2 * part.width, out->cols - 2 * part.x);
  for (int row = part.y; row < part.br().y; ++row) {
    const auto* from = cells.ptr<std::uint8_t>(row) + part.x;
    auto* to = out->ptr<std::uint8_t>(2 * row) + 2 * part.x;
    for (int pair = 0; pair < columns / 2; ++pair) {
      to[2 * pair] = from[pair];
      to[2 * pair + 1] = from[pair];
    }
    if (columns % 2 != 0) {
      to[columns - 1] = from[columns / 2];
    }
    if (2 * row + 1 < out->rows) {
      std::copy_n(to, columns, out->ptr<std::uint8_t>(2 * row + 1) + 2 * part.x);
    }
  }
}

}  // namespace polhode
