// Pixel formats that the driver can turn into gray, and which of those on offer it takes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace polhode::platform {

enum class Packing : std::uint8_t {
  kGray8,       ///< one byte
  kGray16,      ///< two bytes, little endian, `bits` significant ones at the lower end
  kGroups,      ///< groups: a byte a pixel with its upper bits, then the lower bits of all
  kLumaChroma,  ///< two bytes, the first is the luminance
  kChromaLuma,  ///< two bytes, the second is the luminance
  kRgb,         ///< three bytes
  kBgr,         ///< three bytes
  kCompressed,  ///< a JPEG image
};

struct PixelPacking {
  std::uint32_t fourcc = 0;
  Packing packing = Packing::kGray8;
  int bits = 8;             ///< significant bits of a gray value
  int bytes_per_pixel = 1;  ///< of a whole buffer, rounded up; 0: compressed
  std::string_view name;
  int group_pixels = 1;  ///< pixels in a group of a row
  int group_bytes = 1;
};

/// Of a row without padding. Chroma that follows the luminance as a plane of its own is not looked
/// at.
std::uint32_t row_bytes_of(const PixelPacking& packing, int width_px);

/// In order of preference: formats without a copy first, more bits before fewer (though the
/// estimator looks at the upper eight), lossy ones last.
std::span<const PixelPacking> pixel_packings();
const PixelPacking* find_packing(std::uint32_t fourcc);
const PixelPacking* find_packing(std::string_view name);

/// "GREY", or "Y16 -BE" for formats with an unprintable or flagged code.
std::string fourcc_text(std::uint32_t fourcc);

/// A device's answer to a request for a format at a size.
struct OfferedFormat {
  std::uint32_t fourcc = 0;
  int width_px = 0;
  int height_px = 0;
  std::uint32_t row_bytes = 0;
  std::uint32_t image_bytes = 0;  ///< of the plane that the luminance is in
  std::uint32_t field = 1;        ///< V4L2_FIELD_NONE
};

/// V4L2's word for rows that are not of one moment, as "interlaced"; empty where they are.
std::string_view interlacing(std::uint32_t field);

struct FormatRequest {
  int width_px = 0;  ///< exactly: the intrinsics hold for one size
  int height_px = 0;
  std::uint32_t fourcc = 0;  ///< 0: any
};

/// True when rows and image are long enough for that size and of one moment, and not beyond any
/// memory.
bool consistent(const OfferedFormat& offered);

/// The most preferred consistent format of the requested size. @return its index, or nothing.
std::optional<std::size_t> choose_format(std::span<const OfferedFormat> offered,
                                         const FormatRequest& request);

/// A frame interval as V4L2 has it.
struct Interval {
  std::uint32_t numerator = 0;
  std::uint32_t denominator = 1;
};
double rate_hz(Interval interval);  ///< 0 for an interval that is none
Interval interval_of(double rate_hz);

/// The interval nearest to a rate, by ratio. @return its index, or nothing when none is usable.
std::optional<std::size_t> choose_interval(std::span<const Interval> offered, double requested_hz);

}  // namespace polhode::platform
