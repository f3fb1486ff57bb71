// Gray images from PNG, JPEG and PGM files in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/image_view.hpp"

namespace polhode::platform {

using Bytes = std::span<const std::uint8_t>;

/// Why a file is not an image that can be read; nothing when it is.
using Refusal = std::optional<std::string>;

struct ImageHeader {
  int width_px = 0;
  int height_px = 0;
  PixelFormat format = PixelFormat::kGray8;  ///< of the decoded image
  /// Significant bits of 16-bit pixels as the file declares them; 0: it does not. A PGM's
  /// are scaled to 16 by its maxval.
  int significant_bits = 0;
  /// That the library takes for the image as a whole: a JPEG in several scans; else 0.
  std::size_t decoder_bytes = 0;
};

/// A decoded frame. The buffers keep their capacity, so a sequence of one size allocates them once.
struct DecodedImage {
  ImageHeader header;
  std::vector<std::uint8_t> pixels;  ///< rows without padding; 16-bit pixels in the machine's order
  std::vector<std::uint8_t> scratch;  ///< a row on its way to gray

  [[nodiscard]] ImageView view() const;
};

/// Reads the header only: cheap, and gives the size before anything of that size is allocated.
Refusal read_header(Bytes file, ImageHeader& header);

/// Decodes the whole file; a file that ends early or fails its checksums is refused as a whole.
/// Colour becomes luminance (ITU-R BT.601); an alpha channel is dropped.
Refusal decode(Bytes file, DecodedImage& image);

/// Per format, as read_header() and decode(); `image.pixels` has the right size already.
Refusal png_header(Bytes file, ImageHeader& header);
Refusal png_decode(Bytes file, DecodedImage& image);
Refusal jpeg_header(Bytes file, ImageHeader& header);
Refusal jpeg_decode(Bytes file, DecodedImage& image);
Refusal pgm_header(Bytes file, ImageHeader& header);
Refusal pgm_decode(Bytes file, DecodedImage& image);

}  // namespace polhode::platform
