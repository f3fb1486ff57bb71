// Converts a camera's buffer to a gray image. A buffer that needs no conversion is handed on in
// place.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/image_view.hpp"
#include "camera/v4l2/formats.hpp"
#include "camera/v4l2/jpeg_decoder.hpp"

namespace polhode::platform {

class GrayConverter {
 public:
  /// Takes all memory that frames of this format will need. @param format consistent().
  explicit GrayConverter(const OfferedFormat& format);

  /// @param buffer content of the camera's buffer, from its first pixel on.
  /// @param view of `buffer` itself, or of the converter's own image until the next call.
  /// @return false when the buffer ends before its last pixel, or is no whole JPEG image of this
  /// size.
  [[nodiscard]] bool convert(std::span<const std::uint8_t> buffer, ImageView* view);

 private:
  void convert_rows(const std::uint8_t* buffer);

  OfferedFormat format_;
  PixelPacking packing_;
  std::vector<std::uint8_t> image_;       ///< rows without padding
  std::unique_ptr<JpegDecoder> decoder_;  ///< of compressed formats
};

/// One row each. Colour becomes luminance by ITU-R BT.601, in integers.
void widen_row(const std::uint8_t* from, int pixels, int bits, std::uint8_t* to);
/// @param packing Packing::kGroups; the values fill the upper end of 16 bits.
void group_row(const std::uint8_t* from, int pixels, const PixelPacking& packing, std::uint8_t* to);
/// @param from the luminance of the first pixel.
void luma_row(const std::uint8_t* from, int pixels, std::uint8_t* to);
/// @param red  place of red among the three bytes, 0 or 2.
void rgb_row(const std::uint8_t* from, int pixels, int red, std::uint8_t* to);

}  // namespace polhode::platform
