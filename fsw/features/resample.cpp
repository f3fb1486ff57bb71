#include "features/resample.hpp"

#include <algorithm>
#include <cmath>

#include "base/assert.hpp"
#include "base/avx2_dispatch.hpp"

namespace polhode::sift {
namespace {

/// Catmull-Rom: cubic convolution that reproduces quadratics (Keys, 1981).
double cubic(double distance) {
  const double d = std::abs(distance);
  if (d < 1.0) {
    return (1.5 * d - 2.5) * d * d + 1.0;
  }
  return d < 2.0 ? ((-0.5 * d + 2.5) * d - 4.0) * d + 2.0 : 0.0;
}

/// Overlap of an output pixel, [from, to] on the input axis, with input pixel i.
double overlap(double from, double to, int i) {
  return std::max(0.0, std::min(to, i + 0.5) - std::max(from, i - 0.5));
}

/// Weights of taps outside the region go to the outermost pixel inside.
void fill_taps(int in, int out, AxisTaps* axis) {
  const double step = static_cast<double>(in) / out;  // input pixels per output pixel
  const bool enlarges = step <= 1.0;
  axis->taps = std::min(in, enlarges ? kCubicTaps : static_cast<int>(std::ceil(step)) + 1);
  const auto taps = static_cast<std::size_t>(axis->taps);
  POLHODE_ASSERT(taps * static_cast<std::size_t>(out) <= axis->weight.size(), out);
  std::fill_n(axis->weight.begin(), taps * static_cast<std::size_t>(out), 0.0F);
  for (int i = 0; i < out; ++i) {
    const double centre = (i + 0.5) * step - 0.5;
    const double reach = enlarges ? 0.5 * kCubicTaps : 0.5 * step + 0.5;
    const int begin = static_cast<int>(std::floor(centre - reach)) + 1;
    const int end = enlarges ? begin + kCubicTaps : static_cast<int>(std::ceil(centre + reach));
    const int first = std::clamp(begin, 0, in - axis->taps);
    axis->first[static_cast<std::size_t>(i)] = first;
    float* weight = axis->weight.data() + static_cast<std::size_t>(i) * taps;
    for (int k = begin; k < end; ++k) {
      const double w = enlarges ? cubic(k - centre)
                                : overlap(centre - 0.5 * step, centre + 0.5 * step, k) / step;
      const int inside = std::clamp(std::clamp(k, 0, in - 1) - first, 0, axis->taps - 1);
      weight[inside] += static_cast<float>(w);
    }
  }
}

/// A row of the region in light, cached: neighbouring output rows use the same few.
const float* toned(
    const cv::Mat& gray, const cv::Rect& region_px, const Tone& tone, int y, TonedRows* rows) {
  const std::size_t place = static_cast<std::size_t>(y) % TonedRows::kRows;
  float* row = rows->light[place].data();
  if (rows->y[place] != y) {
    rows->y[place] = y;
    const std::uint8_t* from = gray.ptr<std::uint8_t>(region_px.y + y) + region_px.x;
    for (int x = 0; x < region_px.width; ++x) {
      row[x] = tone[from[x]];
    }
  }
  return row;
}

void weigh_rows(const cv::Mat& gray,
                const cv::Rect& region_px,
                const Tone& tone,
                int y,
                ResampleScratch* scratch) {
  const AxisTaps& down = scratch->down;
  float* __restrict row = scratch->row.data();
  const auto width =
      (static_cast<std::size_t>(region_px.width) + kRowGrain - 1) / kRowGrain * kRowGrain;
  std::fill_n(row, width, 0.0F);
  const float* weight = down.weight.data() + static_cast<std::ptrdiff_t>(y) * down.taps;
  for (int k = 0; k < down.taps; ++k) {
    const float* __restrict from =
        toned(gray, region_px, tone, down.first[static_cast<std::size_t>(y)] + k, &scratch->toned);
    const float w = weight[k];
    for (std::size_t begin = 0; begin < width; begin += kRowGrain) {
      for (std::size_t x = begin; x < begin + kRowGrain; ++x) {
        row[x] += w * from[x];
      }
    }
  }
}

template <int kTaps>
void weigh_columns(const float* row, const AxisTaps& across, int width, float* out) {
  const int taps = kTaps > 0 ? kTaps : across.taps;
  for (int x = 0; x < width; ++x) {
    const float* from = row + across.first[static_cast<std::size_t>(x)];
    const float* weight = across.weight.data() + static_cast<std::ptrdiff_t>(x) * taps;
    float sum = 0.0F;
    for (int k = 0; k < taps; ++k) {
      sum += weight[k] * from[k];
    }
    out[x] = sum;
  }
}

}  // namespace

WorkingSize working_size(const cv::Rect& region_px, int pixels_max, double enlarge_max) {
  const double by_area =
      std::sqrt(static_cast<double>(pixels_max) / static_cast<double>(region_px.area()));
  const double by_side =
      static_cast<double>(limits::kWorkingSide) / std::max(region_px.width, region_px.height);
  const double factor = std::min({enlarge_max, by_area, by_side});
  WorkingSize size;
  size.width = std::max(1, static_cast<int>(region_px.width * factor));
  size.height = std::max(1, static_cast<int>(region_px.height * factor));
  size.factor_u = static_cast<double>(size.width) / region_px.width;
  size.factor_v = static_cast<double>(size.height) / region_px.height;
  return size;
}

Tone light_of_gray(double gamma) {
  Tone tone;
  for (std::size_t level = 0; level < tone.size(); ++level) {
    tone[level] =
        static_cast<float>(kFullScale * std::pow(static_cast<double>(level) / kFullScale, gamma));
  }
  return tone;
}

void resample(const cv::Mat& gray,
              const cv::Rect& region_px,
              const Tone& tone,
              ResampleScratch* scratch,
              const Plane& out) {
  POLHODE_ASSERT(region_px.width <= static_cast<int>(limits::kImageSide), region_px.width);
  fill_taps(region_px.width, out.width, &scratch->across);
  fill_taps(region_px.height, out.height, &scratch->down);
  const float* row = scratch->row.data();
  scratch->toned.y.fill(-1);
  for (int y = 0; y < out.height; ++y) {
    with_avx2([&] { weigh_rows(gray, region_px, tone, y, scratch); });
    if (scratch->across.taps == kCubicTaps) {
      weigh_columns<kCubicTaps>(row, scratch->across, out.width, out.row(y));
    } else {
      weigh_columns<0>(row, scratch->across, out.width, out.row(y));
    }
  }
}

}  // namespace polhode::sift
