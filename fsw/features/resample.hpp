// The target's region of a picture, brought to the size that detection works on.
#pragma once

#include <array>
#include <opencv2/core/mat.hpp>

#include "config/limits.hpp"
#include "features/plane.hpp"

namespace polhode::sift {

/// Which pixels make an output pixel along one axis, and with what weights.
struct AxisTaps {
  int taps = 0;
  std::array<int, limits::kWorkingSide> first{};  ///< first input pixel of each output pixel
  std::array<float, 4 * limits::kWorkingSide + limits::kImageSide> weight{};  ///< taps of each
};

/// What each gray level stands for, on the same scale: 0 .. 255.
using Tone = std::array<float, 256>;

/// Light, of a camera that answers it with its power 1 / gamma.
Tone light_of_gray(double gamma);

/// Rows of the region by their tones: the last ones asked for.
struct TonedRows {
  static constexpr std::size_t kRows = 4;  // taps of an enlargement
  std::array<int, kRows> y{};
  std::array<std::array<float, limits::kImageSide + kRowGrain>, kRows> light{};
};

struct ResampleScratch {
  AxisTaps across;
  AxisTaps down;
  TonedRows toned;
  std::array<float, limits::kImageSide + kRowGrain> row{};
};

/// Size of the working picture.
struct WorkingSize {
  int width = 0;
  int height = 0;
  double factor_u = 1.0;  ///< working pixels per image pixel
  double factor_v = 1.0;
};

/// A region of `pixels_max` at most, at most `enlarge_max` times as wide and high, no side over
/// limits::kWorkingSide.
WorkingSize working_size(const cv::Rect& region_px, int pixels_max, double enlarge_max);

/// Enlarges by cubic convolution (Catmull-Rom), reduces by the mean over each output pixel's area.
/// Pixels are weighed by their tone; cubic convolution may overshoot its 0 .. 255. Pixel centres
/// are at integers on both sides.
/// @param out  of the working size.
void resample(const cv::Mat& gray,
              const cv::Rect& region_px,
              const WorkingSize& size,
              const Tone& tone,
              ResampleScratch* scratch,
              const Plane& out);

}  // namespace polhode::sift
