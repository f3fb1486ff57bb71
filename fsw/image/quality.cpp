#include <array>

#include "base/assert.hpp"
#include "image/image.hpp"

namespace polhode {
namespace {

std::array<int, 256> histogram(const cv::Mat& gray) {
  std::array<int, 256> counts{};
  for (int row = 0; row < gray.rows; ++row) {
    const std::uint8_t* pixels = gray.ptr<std::uint8_t>(row);
    for (int column = 0; column < gray.cols; ++column) {
      ++counts[pixels[column]];
    }
  }
  return counts;
}

}  // namespace

ImageQuality assess(const cv::Mat& gray, const ImageOptions& options) {
  POLHODE_ASSERT(gray.type() == CV_8UC1 && gray.total() > 0, gray.type());
  // One pixel in a thousand: a target of 1 % of the picture is ten times that, hot pixels and stars
  // are fewer.
  constexpr double kBrightFraction = 1e-3;
  const std::array<int, 256> counts = histogram(gray);
  const double total = static_cast<double>(gray.total());
  ImageQuality quality;
  int above = 0;
  bool bright_known = false;
  for (int level = 255; level >= 0; --level) {
    above += counts[static_cast<std::size_t>(level)];
    if (level >= options.saturated_level * 255.0) {
      quality.saturated_fraction = above / total;
    }
    if (!bright_known && above >= kBrightFraction * total) {
      quality.bright_level = level / 255.0;
      bright_known = true;
    }
  }
  quality.dark = quality.bright_level < options.dark_level;
  return quality;
}

}  // namespace polhode
