#include "camera/replay/decode.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

namespace polhode::platform {
namespace {

struct Format {
  std::array<std::uint8_t, 8> magic;
  std::size_t magic_bytes;
  Refusal (*header)(Bytes, ImageHeader&);
  Refusal (*decode)(Bytes, DecodedImage&);
};

// By content, not by name: a file with the wrong extension still reads.
constexpr Format kFormats[] = {
    {{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'}, 8, png_header, png_decode},
    {{0xFF, 0xD8, 0xFF}, 3, jpeg_header, jpeg_decode},
    {{'P', '5'}, 2, pgm_header, pgm_decode},
};

const Format* format_of(Bytes file) {
  for (const Format& format : kFormats) {
    const auto magic = std::span(format.magic).first(format.magic_bytes);
    if (file.size() >= magic.size() && std::equal(magic.begin(), magic.end(), file.begin())) {
      return &format;
    }
  }
  return nullptr;
}

Refusal unknown(Bytes file) {
  return file.empty() ? "the file is empty" : "not a PNG, JPEG or binary PGM (P5) image";
}

}  // namespace

ImageView DecodedImage::view() const {
  const int bytes = header.format == PixelFormat::kGray16 ? 2 : 1;
  return {.data = pixels.data(),
          .width_px = header.width_px,
          .height_px = header.height_px,
          .stride_bytes = static_cast<std::ptrdiff_t>(header.width_px) * bytes,
          .format = header.format};
}

Refusal read_header(Bytes file, ImageHeader& header) {
  const Format* format = format_of(file);
  return format == nullptr ? unknown(file) : format->header(file, header);
}

Refusal decode(Bytes file, DecodedImage& image) {
  const Format* format = format_of(file);
  if (format == nullptr) {
    return unknown(file);
  }
  if (Refusal refusal = format->header(file, image.header)) {
    return refusal;
  }
  const std::size_t bytes = image.header.format == PixelFormat::kGray16 ? 2 : 1;
  image.pixels.resize(static_cast<std::size_t>(image.header.width_px) *
                      static_cast<std::size_t>(image.header.height_px) * bytes);
  return format->decode(file, image);
}

}  // namespace polhode::platform
