// Images of a sensor, made up.
#pragma once

#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "base/rng.hpp"

namespace polhode::images {

inline cv::Mat constant(int width, int height, int level) {
  cv::Mat gray(height, width, CV_8UC1);
  gray.setTo(level);
  return gray;
}

inline constexpr int kWidth = 160;
inline constexpr int kHeight = 120;

/// A sensor's image of a body before black space: a smooth texture, shifted by `shift_px`, with
/// noise of its own.
inline cv::Mat image(int shift_px, std::uint64_t seed) {
  cv::Mat gray(kHeight, kWidth, CV_8UC1);
  Rng rng(seed, 0);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const int x = u - shift_px;
      const bool body = x > 40 && x < 120 && v > 20 && v < 100;
      const int texture = 90 + ((x / 5 + v / 7) % 3) * 30;
      gray.at<std::uint8_t>(v, u) =
          static_cast<std::uint8_t>((body ? texture : 2) + static_cast<int>(rng.below(5)));
    }
  }
  return gray;
}

}  // namespace polhode::images
