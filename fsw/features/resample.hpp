// Resamples the target's region of an image to the working size of detection.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>

#include "config/limits.hpp"
#include "features/plane.hpp"

namespace polhode::sift {

/// Largest gray level of 8 bits.
inline constexpr double kFullScale = 255.0;

/// Input pixels of cubic convolution, along one axis.
inline constexpr int kCubicTaps = 4;

/// Input pixels of each output pixel along one axis, and their weights.
struct AxisTaps {
  int taps = 0;
  std::array<int, limits::kWorkingSide> first{};  ///< first input pixel of each output pixel
  /// Taps of each output pixel. A reduction has up to two more than its share of the input.
  std::array<float, kCubicTaps * limits::kWorkingSide + limits::kImageSide> weight{};
};

/// Light of each gray level, on the same scale: 0 .. 255.
using Tone = std::array<float, 256>;

/// For a camera whose gray level is light to the power 1 / gamma.
Tone light_of_gray(double gamma);

/// The last rows of the requested region, as light.
struct TonedRows {
  static constexpr std::size_t kRows = kCubicTaps;  // input rows of an enlarged row
  std::array<int, kRows> y{};
  std::array<std::array<float, limits::kImageSide + kRowGrain>, kRows> light{};
};

struct ResampleScratch {
  AxisTaps across;
  AxisTaps down;
  TonedRows toned;
  std::array<float, limits::kImageSide + kRowGrain> row{};
};

/// Size of the working image.
struct WorkingSize {
  int width = 0;
  int height = 0;
  double factor_u = 1.0;  ///< working pixels per image pixel
  double factor_v = 1.0;
};

/// Size of the working image for a region: at most `pixels_max` pixels, at most `enlarge_max` times
/// as wide and high, no side over limits::kWorkingSide.
WorkingSize working_size(const cv::Rect& region_px, int pixels_max, double enlarge_max);

/// Enlarges by cubic convolution (Catmull-Rom), reduces by the mean over each output pixel's area.
/// Works in light; cubic convolution may overshoot its 0 .. 255. Pixel centres are at integers in
/// both images.
/// @param out  of the working size, and laid out.
void resample(const cv::Mat& gray,
              const cv::Rect& region_px,
              const Tone& tone,
              ResampleScratch* scratch,
              const Plane& out);

}  // namespace polhode::sift
