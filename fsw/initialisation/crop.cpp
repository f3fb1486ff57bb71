#include "initialisation/crop.hpp"

#include <algorithm>
#include <cmath>

namespace polhode {
namespace {

// Margin about a feature that an aligned patch may reach: half its side and its growth along the
// diagonal, the search, and one pixel for interpolation.
constexpr int kMargin_px = 12;

struct Box {
  int left = 0;
  int top = 0;
  int right = 0;   ///< exclusive
  int bottom = 0;  ///< exclusive
};

Box box_of(const cv::Mat& gray, std::span<const Feature> features) {
  float left = features[0].u_px;
  float right = left;
  float top = features[0].v_px;
  float bottom = top;
  for (const Feature& f : features) {
    left = std::min(left, f.u_px);
    right = std::max(right, f.u_px);
    top = std::min(top, f.v_px);
    bottom = std::max(bottom, f.v_px);
  }
  return {.left = std::max(0, static_cast<int>(std::floor(left)) - kMargin_px),
          .top = std::max(0, static_cast<int>(std::floor(top)) - kMargin_px),
          .right = std::min(gray.cols, static_cast<int>(std::ceil(right)) + kMargin_px + 1),
          .bottom = std::min(gray.rows, static_cast<int>(std::ceil(bottom)) + kMargin_px + 1)};
}

std::uint8_t mean_of(const cv::Mat& gray, int left, int top, int side) {
  int sum = 0;
  for (int y = top; y < top + side; ++y) {
    const std::uint8_t* const row = gray.ptr<std::uint8_t>(y);
    for (int x = left; x < left + side; ++x) {
      sum += row[x];
    }
  }
  const int count = side * side;
  return static_cast<std::uint8_t>((sum + count / 2) / count);
}

/// Middle of the first pixel of a crop, from its edge, in the image's pixels.
double half_step(int reduction) { return 0.5 * (reduction - 1); }

void take_crop(const cv::Mat& gray, std::span<const Feature> features, Crop* crop) {
  crop->width = crop->height = 0;
  if (features.empty()) {
    return;
  }
  const Box box = box_of(gray, features);
  const int width = box.right - box.left;
  const int height = box.bottom - box.top;
  if (width <= 0 || height <= 0) {
    return;
  }
  crop->reduction = 1;
  while (static_cast<std::size_t>(width / crop->reduction) *
             static_cast<std::size_t>(height / crop->reduction) >
         limits::kCropPixels) {
    ++crop->reduction;
  }
  crop->left_px = box.left;
  crop->top_px = box.top;
  crop->width = width / crop->reduction;
  crop->height = height / crop->reduction;
  std::size_t at = 0;
  for (int y = 0; y < crop->height; ++y) {
    for (int x = 0; x < crop->width; ++x) {
      crop->levels[at++] = mean_of(
          gray, box.left + x * crop->reduction, box.top + y * crop->reduction, crop->reduction);
    }
  }
}

}  // namespace

Eigen::Vector2d Crop::to_crop(const Eigen::Vector2d& image_px) const {
  return (image_px - Eigen::Vector2d(left_px, top_px)).array() / reduction -
         half_step(reduction) / reduction;
}

Eigen::Vector2d Crop::to_image(const Eigen::Vector2d& crop_px) const {
  return (crop_px * reduction).array() + half_step(reduction) + Eigen::Array2d(left_px, top_px);
}

void keep_crop(const cv::Mat& gray,
               std::uint32_t frame,
               std::span<const Feature> features,
               Crops* crops) {
  // Frame numbers begin again when a component does.
  const int same = find_crop(frame, *crops);
  if (same >= 0) {
    crops->kept[static_cast<std::size_t>(same)].width = 0;
  }
  Crop& crop = crops->kept[crops->taken++ % limits::kInitialFrames];
  crop.frame = frame;
  take_crop(gray, features, &crop);
}

int find_crop(std::uint32_t frame, const Crops& crops) {
  for (std::size_t i = 0; i < crops.kept.size(); ++i) {
    if (crops.kept[i].width > 0 && crops.kept[i].frame == frame) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

}  // namespace polhode
