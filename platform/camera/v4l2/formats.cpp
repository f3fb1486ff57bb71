#include "camera/v4l2/formats.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>

namespace polhode::platform {
namespace {

constexpr std::array<PixelPacking, 8> kPackings{{
    {V4L2_PIX_FMT_GREY, Packing::kGray8, 8, 1, "GREY"},
    {V4L2_PIX_FMT_Y16, Packing::kGray16, 16, 2, "Y16"},
    {V4L2_PIX_FMT_Y12, Packing::kGray16, 12, 2, "Y12"},
    {V4L2_PIX_FMT_Y10, Packing::kGray16, 10, 2, "Y10"},
    {V4L2_PIX_FMT_YUYV, Packing::kLumaChroma, 8, 2, "YUYV"},
    {V4L2_PIX_FMT_RGB24, Packing::kRgb, 8, 3, "RGB24"},
    {V4L2_PIX_FMT_MJPEG, Packing::kCompressed, 8, 0, "MJPEG"},
    {V4L2_PIX_FMT_JPEG, Packing::kCompressed, 8, 0, "JPEG"},
}};

constexpr std::uint32_t kImageOctetsMax = 256U << 20U;  // 8192 x 8192 at 4 octets

std::size_t rank(std::uint32_t fourcc) {
  const auto* found = find_packing(fourcc);
  return found == nullptr ? kPackings.size() : static_cast<std::size_t>(found - kPackings.data());
}

}  // namespace

std::span<const PixelPacking> pixel_packings() { return kPackings; }

const PixelPacking* find_packing(std::uint32_t fourcc) {
  const auto* found = std::find_if(
      kPackings.begin(), kPackings.end(), [&](const auto& p) { return p.fourcc == fourcc; });
  return found == kPackings.end() ? nullptr : found;
}

const PixelPacking* find_packing(std::string_view name) {
  const auto* found = std::find_if(
      kPackings.begin(), kPackings.end(), [&](const auto& p) { return p.name == name; });
  return found == kPackings.end() ? nullptr : found;
}

std::string fourcc_text(std::uint32_t fourcc) {
  constexpr std::uint32_t kBigEndian = 1U << 31U;
  std::string text;
  for (unsigned i = 0; i < 4; ++i) {
    const auto letter = static_cast<char>((fourcc & ~kBigEndian) >> (8 * i) & 0xFFU);
    text += letter >= ' ' && letter <= '~' ? letter : '.';
  }
  text.erase(text.find_last_not_of(' ') + 1);
  return (fourcc & kBigEndian) != 0 ? text + "-BE" : text;
}

bool consistent(const OfferedFormat& offered) {
  const PixelPacking* packing = find_packing(offered.fourcc);
  if (packing == nullptr || offered.width_px <= 0 || offered.height_px <= 0 ||
      offered.image_octets == 0 || offered.image_octets > kImageOctetsMax) {
    return false;
  }
  if (packing->packing == Packing::kCompressed) {
    return true;
  }
  const auto row = static_cast<std::uint64_t>(offered.width_px) *
                   static_cast<std::uint64_t>(packing->octets_per_pixel);
  const auto rows = static_cast<std::uint64_t>(offered.height_px);
  return offered.row_octets >= row && offered.image_octets >= offered.row_octets * (rows - 1) + row;
}

std::optional<std::size_t> choose_format(std::span<const OfferedFormat> offered,
                                         const FormatWish& wish) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < offered.size(); ++i) {
    const OfferedFormat& format = offered[i];
    const bool fits = format.width_px == wish.width_px && format.height_px == wish.height_px &&
                      (wish.fourcc == 0 || format.fourcc == wish.fourcc) && consistent(format);
    if (fits && (!best || rank(format.fourcc) < rank(offered[*best].fourcc))) {
      best = i;
    }
  }
  return best;
}

double rate_hz(Interval interval) {
  if (interval.numerator == 0 || interval.denominator == 0) {
    return 0.0;
  }
  return static_cast<double>(interval.denominator) / static_cast<double>(interval.numerator);
}

Interval interval_of(double rate_hz) {
  return {.numerator = 1000,
          .denominator = static_cast<std::uint32_t>(std::lround(1000.0 * rate_hz))};
}

std::optional<std::size_t> choose_interval(std::span<const Interval> offered, double wished_hz) {
  std::optional<std::size_t> best;
  double least = 0.0;
  for (std::size_t i = 0; i < offered.size(); ++i) {
    const double hz = rate_hz(offered[i]);
    if (hz <= 0.0) {
      continue;
    }
    const double distance = std::abs(std::log(hz / wished_hz));
    if (!best || distance < least) {
      best = i;
      least = distance;
    }
  }
  return best;
}

}  // namespace polhode::platform
