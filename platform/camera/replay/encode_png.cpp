#include "camera/replay/encode_png.hpp"

#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstdio>
#include <memory>
#include <vector>

#include "errors.hpp"

namespace polhode::platform {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

/// libpng leaves by longjmp: nothing that has a destructor lives in here.
bool write_rows(std::FILE* file, const ImageView& image, png_bytep* rows) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png == nullptr ? nullptr : png_create_info_struct(png);
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  const bool deep = image.format == PixelFormat::kGray16;
  png_init_io(png, file);
  png_set_IHDR(png,
               info,
               static_cast<png_uint_32>(image.width_px),
               static_cast<png_uint_32>(image.height_px),
               deep ? 16 : 8,
               PNG_COLOR_TYPE_GRAY,
               PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (deep) {
    const png_color_8 all{.red = 0, .green = 0, .blue = 0, .gray = 16, .alpha = 0};
    png_set_sBIT(png, info, &all);  // dark ones are not to be taken for those of fewer bits
  }
  png_set_compression_level(png, 3);
  png_write_info(png, info);
  if (deep) {
    png_set_swap(png);  // the file is big endian
  }
  png_write_image(png, rows);
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return true;
}

}  // namespace

void write_png(const std::filesystem::path& file, const ImageView& image) {
  std::vector<png_bytep> rows;
  for (int v = 0; v < image.height_px; ++v) {
    rows.push_back(const_cast<png_bytep>(image.data + v * image.stride_bytes));
  }
  File out(std::fopen(file.c_str(), "wbe"));
  const bool written = out != nullptr && write_rows(out.get(), image, rows.data());
  if (!written || std::fclose(out.release()) != 0) {
    throw RunFailure(fmt::format("{}: cannot be written", file.string()));
  }
}

}  // namespace polhode::platform
