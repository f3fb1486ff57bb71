#include "camera/v4l2/formats.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <cmath>

namespace polhode::platform {
namespace {

// Of kernels after the one whose header this may be built with.
constexpr std::uint32_t kY12P = v4l2_fourcc('Y', '1', '2', 'P');
constexpr std::uint32_t kY14P = v4l2_fourcc('Y', '1', '4', 'P');

// An M at the end: chroma in a buffer of its own, which is not mapped.
constexpr std::array<PixelPacking, 23> kPackings{{
    {V4L2_PIX_FMT_GREY, Packing::kGray8, 8, 1, "GREY"},
    {V4L2_PIX_FMT_Y16, Packing::kGray16, 16, 2, "Y16", 1, 2},
    {kY14P, Packing::kGroups, 14, 2, "Y14P", 4, 7},
    {V4L2_PIX_FMT_Y12, Packing::kGray16, 12, 2, "Y12", 1, 2},
    {kY12P, Packing::kGroups, 12, 2, "Y12P", 2, 3},
    {V4L2_PIX_FMT_Y10, Packing::kGray16, 10, 2, "Y10", 1, 2},
    {V4L2_PIX_FMT_Y10P, Packing::kGroups, 10, 2, "Y10P", 4, 5},
    {V4L2_PIX_FMT_NV12, Packing::kGray8, 8, 2, "NV12"},
    {V4L2_PIX_FMT_NV12M, Packing::kGray8, 8, 1, "NV12M"},
    {V4L2_PIX_FMT_NV21, Packing::kGray8, 8, 2, "NV21"},
    {V4L2_PIX_FMT_NV21M, Packing::kGray8, 8, 1, "NV21M"},
    {V4L2_PIX_FMT_NV16, Packing::kGray8, 8, 2, "NV16"},
    {V4L2_PIX_FMT_NV16M, Packing::kGray8, 8, 1, "NV16M"},
    {V4L2_PIX_FMT_YUV420, Packing::kGray8, 8, 2, "YUV420"},
    {V4L2_PIX_FMT_YUV420M, Packing::kGray8, 8, 1, "YUV420M"},
    {V4L2_PIX_FMT_YUYV, Packing::kLumaChroma, 8, 2, "YUYV", 1, 2},
    {V4L2_PIX_FMT_UYVY, Packing::kChromaLuma, 8, 2, "UYVY", 1, 2},
    {V4L2_PIX_FMT_YVYU, Packing::kLumaChroma, 8, 2, "YVYU", 1, 2},
    {V4L2_PIX_FMT_VYUY, Packing::kChromaLuma, 8, 2, "VYUY", 1, 2},
    {V4L2_PIX_FMT_RGB24, Packing::kRgb, 8, 3, "RGB24", 1, 3},
    {V4L2_PIX_FMT_BGR24, Packing::kBgr, 8, 3, "BGR24", 1, 3},
    {V4L2_PIX_FMT_MJPEG, Packing::kCompressed, 8, 0, "MJPEG"},
    {V4L2_PIX_FMT_JPEG, Packing::kCompressed, 8, 0, "JPEG"},
}};

constexpr std::uint32_t kImageBytesMax = 256U << 20U;  // 8192 x 8192 at 4 bytes

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

std::uint32_t row_bytes_of(const PixelPacking& packing, int width_px) {
  const int groups = (width_px + packing.group_pixels - 1) / packing.group_pixels;
  return static_cast<std::uint32_t>(groups) * static_cast<std::uint32_t>(packing.group_bytes);
}

std::string_view interlacing(std::uint32_t field) {
  switch (field) {
    case V4L2_FIELD_ANY:  // of drivers that leave it open
    case V4L2_FIELD_NONE:
      return "";
    case V4L2_FIELD_TOP:
      return "top fields";
    case V4L2_FIELD_BOTTOM:
      return "bottom fields";
    case V4L2_FIELD_INTERLACED:
    case V4L2_FIELD_INTERLACED_TB:
    case V4L2_FIELD_INTERLACED_BT:
      return "interlaced";
    case V4L2_FIELD_SEQ_TB:
    case V4L2_FIELD_SEQ_BT:
      return "both fields, one after the other";
    case V4L2_FIELD_ALTERNATE:
      return "top and bottom fields in turn";
    default:
      return "fields of an unknown order";
  }
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
      offered.image_bytes == 0 || offered.image_bytes > kImageBytesMax ||
      !interlacing(offered.field).empty()) {
    return false;
  }
  if (packing->packing == Packing::kCompressed) {
    return true;
  }
  const std::uint64_t row = row_bytes_of(*packing, offered.width_px);
  const auto rows = static_cast<std::uint64_t>(offered.height_px);
  return offered.row_bytes >= row && offered.image_bytes >= offered.row_bytes * (rows - 1) + row;
}

std::optional<std::size_t> choose_format(std::span<const OfferedFormat> offered,
                                         const FormatRequest& request) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < offered.size(); ++i) {
    const OfferedFormat& format = offered[i];
    const bool fits =
        format.width_px == request.width_px && format.height_px == request.height_px &&
        (request.fourcc == 0 || format.fourcc == request.fourcc) && consistent(format);
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

std::optional<std::size_t> choose_interval(std::span<const Interval> offered, double requested_hz) {
  std::optional<std::size_t> best;
  double least = 0.0;
  for (std::size_t i = 0; i < offered.size(); ++i) {
    const double hz = rate_hz(offered[i]);
    if (hz <= 0.0) {
      continue;
    }
    const double distance = std::abs(std::log(hz / requested_hz));
    if (!best || distance < least) {
      best = i;
      least = distance;
    }
  }
  return best;
}

}  // namespace polhode::platform
