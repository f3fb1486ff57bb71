#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "base/assert.hpp"
#include "image/quality.hpp"

namespace polhode {
namespace {

using Histogram = std::array<int, 256>;

/// Neighbouring pixels are often alike: with four tables their increments do not wait for each
/// other.
Histogram histogram(const cv::Mat& gray, int row_step) {
  std::array<Histogram, 4> part{};
  for (int row = 0; row < gray.rows; row += row_step) {
    const std::uint8_t* pixels = gray.ptr<std::uint8_t>(row);
    int column = 0;
    for (; column + 4 <= gray.cols; column += 4) {
      ++part[0][pixels[column]];
      ++part[1][pixels[column + 1]];
      ++part[2][pixels[column + 2]];
      ++part[3][pixels[column + 3]];
    }
    for (; column < gray.cols; ++column) {
      ++part[0][pixels[column]];
    }
  }
  for (std::size_t level = 0; level < part[0].size(); ++level) {
    part[0][level] += part[1][level] + part[2][level] + part[3][level];
  }
  return part[0];
}

/// Sharpness: mean change over one pixel by that over four. Blur lowers the first more than the
/// second.
double sharpness(const cv::Mat& gray, int lit_level) {
  constexpr int kRowStep = 8;  // with every second column a sixteenth of the pixels
  constexpr int kFar_px = 4;   // over a blur of two or three pixels. Chosen
  std::int64_t near = 0;
  std::int64_t far = 0;
  for (int row = kRowStep / 2; row < gray.rows; row += kRowStep) {
    const std::uint8_t* p = gray.ptr<std::uint8_t>(row);
    for (int column = 0; column + kFar_px < gray.cols; column += 2) {
      if (p[column] > lit_level && p[column + kFar_px] > lit_level) {
        near += std::abs(p[column + 1] - p[column]);
        far += std::abs(p[column + kFar_px] - p[column]);
      }
    }
  }
  return far > 0 ? static_cast<double>(near) / static_cast<double>(far) : 0.0;
}

}  // namespace

ImageLevels measure_levels(const cv::Mat& gray, const ImageOptions& options) {
  POLHODE_ASSERT(gray.type() == CV_8UC1 && gray.total() > 0, gray.type());
  // One pixel in a thousand: a target of 1 % of the image is ten times that; hot pixels and stars
  // are fewer.
  constexpr double kBrightFraction = 1e-3;
  // In a large image a fixed number: the smallest target that can be tracked, 20 x 20 px, is less
  // than 0.1 %.
  constexpr double kBright_px = 400.0;
  // Least pixels of the sample: a thousandth of them scatters by 4.5 %.
  constexpr double kEnough_px = 5e5;
  const int row_step =
      std::max(1, static_cast<int>(std::lround(static_cast<double>(gray.total()) / kEnough_px)));
  const Histogram counts = histogram(gray, row_step);
  double total = 0.0;
  double sum = 0.0;
  for (std::size_t level = 0; level < counts.size(); ++level) {
    total += counts[level];
    sum += static_cast<double>(level) * counts[level];
  }
  const double bright = std::min(kBrightFraction * total, kBright_px / row_step);
  ImageLevels levels;
  levels.mean_level = sum / total / 255.0;
  levels.dim_level = 1.0;  // of an image that is all at full scale
  int above = 0;
  int lit = 0;
  int saturated = 0;
  bool bright_known = false;
  for (int level = 255; level >= 0; --level) {
    above += counts[static_cast<std::size_t>(level)];
    saturated = level >= options.saturated_level * 255.0 ? above : saturated;
    lit = level > options.dark_level * 255.0 ? above : lit;
    if (!bright_known && above >= bright) {
      levels.bright_level = level / 255.0;
      bright_known = true;
    }
    if (above <= (1.0 - kBrightFraction) * total) {
      levels.dim_level = (level > 0 ? level - 1 : 0) / 255.0;
    }
  }
  levels.saturated_fraction = saturated / total;
  levels.lit_fraction = lit / total;
  levels.sharpness = sharpness(gray, static_cast<int>(options.dark_level * 255.0));
  levels.dark = levels.bright_level < options.dark_level;
  return levels;
}

}  // namespace polhode
