// The target's part of a kept frame's image, for the alignment of tracks.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <span>

#include "config/limits.hpp"
#include "features/feature.hpp"

namespace polhode {

/// A rectangle of the image that contains the features with a margin. Where it has more pixels than
/// there is room for, each of its pixels is the mean of `reduction` x `reduction` of the image's.
struct Crop {
  std::uint32_t frame = 0;
  int left_px = 0;  ///< in the image
  int top_px = 0;
  int width = 0;  ///< of the crop, in its own pixels; 0: there is none
  int height = 0;
  int reduction = 1;
  std::array<std::uint8_t, limits::kCropPixels> levels{};

  /// A place of the image in the crop's own pixels.
  [[nodiscard]] Eigen::Vector2d to_crop(const Eigen::Vector2d& image_px) const;
  [[nodiscard]] Eigen::Vector2d to_image(const Eigen::Vector2d& crop_px) const;
};

/// Crops of the newest kept frames. A new one takes the place of the oldest.
struct Crops {
  std::array<Crop, limits::kInitialFrames> kept;
  std::uint32_t taken = 0;  ///< number of crops kept so far
};

/// @param gray  8-bit.
void keep_crop(const cv::Mat& gray,
               std::uint32_t frame,
               std::span<const Feature> features,
               Crops* crops);

/// Index of a frame's crop; -1: not there.
int find_crop(std::uint32_t frame, const Crops& crops);

}  // namespace polhode
