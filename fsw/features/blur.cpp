#include "features/blur.hpp"

#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "features/lanes.hpp"

namespace polhode::sift {
namespace {

/// Index of a pixel past the border, mirrored. @pre size >= 1
int mirrored(int i, int size) {
  if (size == 1) {
    return 0;
  }
  while (i < 0 || i >= size) {
    i = i < 0 ? -i : 2 * (size - 1) - i;
  }
  return i;
}

/// The two neighbours at each distance from the middle: two rows of the image, or two shifts of one
/// row.
struct Neighbours {
  std::array<const float*, GaussianKernel::kRadiusMax + 1> before{};
  std::array<const float*, GaussianKernel::kRadiusMax + 1> after{};
};

/// Several groups of lanes at a time: weights and addresses are fetched once for all of them.
template <class Lanes, int kGroups>
void weigh_at(const Neighbours& from, const GaussianKernel& kernel, int x, float* to) {
  std::array<Lanes, kGroups> sum;
#pragma GCC unroll 8
  for (int g = 0; g < kGroups; ++g) {
    sum[static_cast<std::size_t>(g)] =
        splat<Lanes>(kernel.weight[0]) * load<Lanes>(from.before[0] + x + g * kLanes<Lanes>);
  }
  for (std::size_t k = 1; k <= static_cast<std::size_t>(kernel.radius); ++k) {
    const Lanes weight = splat<Lanes>(kernel.weight[k]);
    const float* before = from.before[k] + x;
    const float* after = from.after[k] + x;
#pragma GCC unroll 8
    for (int g = 0; g < kGroups; ++g) {
      sum[static_cast<std::size_t>(g)] += weight * (load<Lanes>(before + g * kLanes<Lanes>) +
                                                    load<Lanes>(after + g * kLanes<Lanes>));
    }
  }
#pragma GCC unroll 8
  for (int g = 0; g < kGroups; ++g) {
    store(sum[static_cast<std::size_t>(g)], to + x + g * kLanes<Lanes>);
  }
}

template <class Lanes>
void weigh(const Neighbours& from, const GaussianKernel& kernel, int width, float* to) {
  // Groups of lanes at a time. Chosen: sums, weight and operands stay in the 16 registers of x86.
  // At most the 8 that the loops are unrolled for. Changes no value.
  constexpr int kGroups = 6;
  constexpr int kTogether = kGroups * kLanes<Lanes>;
  int x = 0;
  for (; x + kTogether <= width; x += kTogether) {
    weigh_at<Lanes, kGroups>(from, kernel, x, to);
  }
  for (; x < width; x += kLanes<Lanes>) {
    weigh_at<Lanes, 1>(from, kernel, x, to);
  }
}

template <class Lanes>
void blur_by(const Plane& in, const GaussianKernel& kernel, BlurRow* scratch, const Plane& out) {
  float* row = scratch->data() + GaussianKernel::kRadiusMax;
  const int radius = kernel.radius;
  Neighbours vertical;
  Neighbours horizontal;
  for (int k = 0; k <= radius; ++k) {
    horizontal.before[static_cast<std::size_t>(k)] = row - k;
    horizontal.after[static_cast<std::size_t>(k)] = row + k;
  }
  for (int y = 0; y < in.height; ++y) {
    for (int k = 0; k <= radius; ++k) {
      vertical.before[static_cast<std::size_t>(k)] = in.row(mirrored(y - k, in.height));
      vertical.after[static_cast<std::size_t>(k)] = in.row(mirrored(y + k, in.height));
    }
    weigh<Lanes>(vertical, kernel, in.width, row);
    for (int k = 1; k <= radius; ++k) {
      row[-k] = row[mirrored(-k, in.width)];
      row[in.width - 1 + k] = row[mirrored(in.width - 1 + k, in.width)];
    }
    weigh<Lanes>(horizontal, kernel, in.width, out.row(y));
  }
}

}  // namespace

GaussianKernel gaussian_kernel(double sigma_px) {
  constexpr double kCut = 3.2;  // 1.4e-3 of a Gaussian lies beyond
  POLHODE_ASSERT(sigma_px > 0.0 && sigma_px * kCut <= GaussianKernel::kRadiusMax, sigma_px);
  GaussianKernel kernel;
  kernel.radius = static_cast<int>(std::ceil(sigma_px * kCut - 0.5));
  kernel.radius = std::max(kernel.radius, 1);
  std::array<double, GaussianKernel::kRadiusMax + 1> weight{};
  double sum = 0.0;
  for (int k = 0; k <= kernel.radius; ++k) {
    weight[static_cast<std::size_t>(k)] = std::exp(-0.5 * k * k / (sigma_px * sigma_px));
    sum += weight[static_cast<std::size_t>(k)] * (k == 0 ? 1.0 : 2.0);
  }
  for (std::size_t k = 0; k < weight.size(); ++k) {
    kernel.weight[k] = static_cast<float>(weight[k] / sum);
  }
  return kernel;
}

void blur(const Plane& in, const GaussianKernel& kernel, BlurRow* scratch, const Plane& out) {
  POLHODE_ASSERT(in.width == out.width && in.height == out.height, out.width);
  POLHODE_ASSERT(in.width <= static_cast<int>(limits::kWorkingSide), in.width);
  with_lanes([&](auto kind) { blur_by<typename decltype(kind)::Lanes>(in, kernel, scratch, out); });
}

}  // namespace polhode::sift
