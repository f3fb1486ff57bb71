#include "features/scale_space.hpp"

#include <algorithm>
#include <cmath>

#include "base/assert.hpp"

namespace polhode::sift {
namespace {

void halve(const Plane& in, const Plane& out) {
  for (int y = 0; y < out.height; ++y) {
    const float* from = in.row(2 * y);
    float* to = out.row(y);
    for (int x = 0; x < out.width; ++x) {
      to[x] = from[2 * x];
    }
  }
}

double blur_between(double from_px, double to_px) {
  return std::sqrt(to_px * to_px - from_px * from_px);
}

}  // namespace

float sigma_of_level(float level) {
  return static_cast<float>(ScaleSpace::kSigma_px) * std::exp2(level / ScaleSpace::kLayers);
}

Plane lay_out_scale_space(int width, int height, ScaleSpace* space) {
  POLHODE_ASSERT(
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height) <= limits::kWorkingPixels,
      width);
  POLHODE_ASSERT(std::max(width, height) <= static_cast<int>(limits::kWorkingSide), height);
  float* free = space->memory.data();
  space->octaves = 0;
  while (space->octaves < ScaleSpace::kOctaves && std::min(width, height) >= ScaleSpace::kSideMin) {
    for (Plane& level : space->level[static_cast<std::size_t>(space->octaves)]) {
      level = {.data = free, .width = width, .height = height, .stride = stride_of(width)};
      free += static_cast<std::ptrdiff_t>(level.stride) * height;
    }
    ++space->octaves;
    width /= 2;
    height /= 2;
  }
  POLHODE_ASSERT(free <= space->memory.data() + space->memory.size(), height);
  // The image is stored in the second level, from which it is blurred into the first.
  return space->octaves > 0 ? space->level[0][1] : Plane{};
}

void fill_scale_space(double blur_px, ScaleSpace* space) {
  for (int o = 0; o < space->octaves; ++o) {
    auto& level = space->level[static_cast<std::size_t>(o)];
    if (o == 0) {
      // Less blur has no effect: a kernel of 0.1 px has weights of 1e-22 beside the middle.
      constexpr double kLeast_px = 0.1;
      const double missing_px =
          blur_between(std::min(blur_px, ScaleSpace::kSigma_px), ScaleSpace::kSigma_px);
      blur(level[1], gaussian_kernel(std::max(kLeast_px, missing_px)), &space->row, level[0]);
    } else {
      halve(space->level[static_cast<std::size_t>(o) - 1][ScaleSpace::kLayers], level[0]);
    }
    for (std::size_t i = 1; i < ScaleSpace::kLevels; ++i) {
      const double before_px = static_cast<double>(sigma_of_level(static_cast<float>(i - 1)));
      const double after_px = static_cast<double>(sigma_of_level(static_cast<float>(i)));
      blur(level[i - 1], gaussian_kernel(blur_between(before_px, after_px)), &space->row, level[i]);
    }
  }
}

}  // namespace polhode::sift
