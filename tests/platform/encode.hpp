// Image files in memory for the tests of the decoders.
#pragma once

#include <png.h>
#include <turbojpeg.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace polhode::platform {

using File = std::vector<std::uint8_t>;

struct PngShape {
  int width = 0;
  int height = 0;
  int depth = 8;
  int colour_type = PNG_COLOR_TYPE_GRAY;
  int interlace = PNG_INTERLACE_NONE;
  std::vector<png_color> palette = {};
};

/// @param rows raw rows as libpng takes them: 16-bit samples big-endian.
inline File encode_png(const PngShape& shape, const File& rows) {
  File out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png,
      &out,
      [](png_structp p, png_bytep data, png_size_t size) {
        auto* file = static_cast<File*>(png_get_io_ptr(p));
        file->insert(file->end(), data, data + size);
      },
      nullptr);
  png_set_IHDR(png,
               info,
               static_cast<png_uint_32>(shape.width),
               static_cast<png_uint_32>(shape.height),
               shape.depth,
               shape.colour_type,
               shape.interlace,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (!shape.palette.empty()) {
    png_set_PLTE(png, info, shape.palette.data(), static_cast<int>(shape.palette.size()));
  }
  png_write_info(png, info);
  const std::size_t stride = png_get_rowbytes(png, info);
  std::vector<png_bytep> pointers;
  File copy = rows;
  for (int row = 0; row < shape.height; ++row) {
    pointers.push_back(copy.data() + static_cast<std::size_t>(row) * stride);
  }
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return out;
}

inline File encode_jpeg(int width, int height, const File& gray, int flags = 0) {
  tjhandle encoder = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long size = 0;
  tjCompress2(
      encoder, gray.data(), width, 0, height, TJPF_GRAY, &data, &size, TJSAMP_GRAY, 95, flags);
  File out(data, data + size);
  tjFree(data);
  tjDestroy(encoder);
  return out;
}

inline File encode_pgm(int width, int height, int maxval, const File& samples) {
  const std::string head = "P5\n# a comment\n" + std::to_string(width) + " " +
                           std::to_string(height) + "\n" + std::to_string(maxval) + "\n";
  File out(head.begin(), head.end());
  out.insert(out.end(), samples.begin(), samples.end());
  return out;
}

}  // namespace polhode::platform
