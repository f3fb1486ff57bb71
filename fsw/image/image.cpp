#include "image/image.hpp"

#include <cstring>

#include "base/assert.hpp"

namespace polhode {

void import_frame(const ImageView& frame, cv::Mat* gray) {
  POLHODE_ASSERT(frame.data != nullptr, 0.0);
  gray->create(frame.height_px, frame.width_px, CV_8UC1);
  const auto width = static_cast<std::size_t>(frame.width_px);
  for (int row = 0; row < frame.height_px; ++row) {
    const std::uint8_t* from = frame.data + row * frame.stride_bytes;
    std::uint8_t* to = gray->ptr<std::uint8_t>(row);
    if (frame.format == PixelFormat::kGray8) {
      std::memcpy(to, from, width);
      continue;
    }
    for (std::size_t column = 0; column < width; ++column) {
      std::uint16_t pixel = 0;
      std::memcpy(&pixel, from + 2 * column, sizeof pixel);
      to[column] = static_cast<std::uint8_t>(pixel >> 8U);
    }
  }
}

}  // namespace polhode
