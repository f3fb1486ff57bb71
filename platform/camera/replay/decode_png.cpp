// PNG by libpng. The library leaves by longjmp, so every function that sets a jump holds only plain
// variables that were there before the jump was set.
#include <png.h>

#include <algorithm>
#include <bit>
#include <csetjmp>
#include <cstddef>
#include <cstring>

#include "camera/replay/decode.hpp"

namespace polhode::platform {
namespace {

struct Source {
  Octets file;
  std::size_t position = 0;
  char message[128] = {};  // plain memory: it is written just before a jump
};

void on_error(png_structp png, png_const_charp text) {
  auto* source = static_cast<Source*>(png_get_error_ptr(png));
  std::strncpy(source->message, text, sizeof source->message - 1);
  png_longjmp(png, 1);
}

void on_warning(png_structp /*png*/, png_const_charp /*text*/) {}  // colour profiles and the like

void on_read(png_structp png, png_bytep out, png_size_t count) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (source->file.size() - source->position < count) {
    png_error(png, "the file ends early");
  }
  std::memcpy(out, source->file.data() + source->position, count);
  source->position += count;
}

/// Owns libpng's structures for one pass over one file.
class Reader {
 public:
  explicit Reader(Octets file) : source_{.file = file} {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &source_, on_error, on_warning);
    info_ = png_ == nullptr ? nullptr : png_create_info_struct(png_);
  }
  ~Reader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  bool read_info() {
    if (info_ == nullptr || setjmp(png_jmpbuf(png_)) != 0) {
      return false;
    }
    png_set_read_fn(png_, &source_, on_read);
    png_read_info(png_, info_);
    return true;
  }

  /// Asks for 1 or 3 channels of 8 or 16 bits in the machine's order.
  bool set_transformations() {
    if (setjmp(png_jmpbuf(png_)) != 0) {
      return false;
    }
    png_set_palette_to_rgb(png_);
    png_set_expand_gray_1_2_4_to_8(png_);
    png_set_strip_alpha(png_);
    if (std::endian::native == std::endian::little) {
      png_set_swap(png_);
    }
    passes_ = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    return true;
  }

  /// @param rows at least height() * row_octets() octets.
  bool read_rows(std::uint8_t* rows) {
    if (setjmp(png_jmpbuf(png_)) != 0) {
      return false;
    }
    const std::size_t stride = row_octets();
    for (int pass = 0; pass < passes_; ++pass) {
      for (png_uint_32 row = 0; row < height(); ++row) {
        png_read_row(png_, rows + row * stride, nullptr);
      }
    }
    png_read_end(png_, nullptr);
    return true;
  }

  [[nodiscard]] png_uint_32 width() const { return png_get_image_width(png_, info_); }
  [[nodiscard]] png_uint_32 height() const { return png_get_image_height(png_, info_); }
  [[nodiscard]] bool deep() const { return png_get_bit_depth(png_, info_) == 16; }
  [[nodiscard]] bool colour() const { return png_get_channels(png_, info_) >= 3; }
  [[nodiscard]] std::size_t row_octets() const { return png_get_rowbytes(png_, info_); }
  [[nodiscard]] std::string reason() const { return std::string("PNG: ") + source_.message; }

 private:
  Source source_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  int passes_ = 1;
};

/// Luminance by ITU-R BT.601 in integers, weights in 1/65536: the same on every machine.
template <typename Sample>
void to_gray(const std::uint8_t* colour, std::uint8_t* gray, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    Sample rgb[3];
    std::memcpy(rgb, colour + i * sizeof rgb, sizeof rgb);
    const std::uint64_t sum = 19595ULL * rgb[0] + 38470ULL * rgb[1] + 7471ULL * rgb[2];
    const auto value = static_cast<Sample>((sum + 32768ULL) >> 16U);
    std::memcpy(gray + i * sizeof value, &value, sizeof value);
  }
}

}  // namespace

Refusal png_header(Octets file, ImageHeader& header) {
  Reader reader(file);
  if (!reader.read_info()) {
    return reader.reason();
  }
  header = {.width_px = static_cast<int>(std::min<png_uint_32>(reader.width(), 1U << 30U)),
            .height_px = static_cast<int>(std::min<png_uint_32>(reader.height(), 1U << 30U)),
            .format = reader.deep() ? PixelFormat::kGray16 : PixelFormat::kGray8};
  return std::nullopt;
}

Refusal png_decode(Octets file, DecodedImage& image) {
  Reader reader(file);
  if (!reader.read_info() || !reader.set_transformations()) {
    return reader.reason();
  }
  const bool colour = reader.colour();
  if (colour) {
    image.scratch.resize(reader.row_octets() * reader.height());
  }
  if (!reader.read_rows(colour ? image.scratch.data() : image.pixels.data())) {
    return reader.reason();
  }
  if (colour) {
    const std::size_t count = std::size_t{reader.width()} * reader.height();
    if (image.header.format == PixelFormat::kGray16) {
      to_gray<std::uint16_t>(image.scratch.data(), image.pixels.data(), count);
    } else {
      to_gray<std::uint8_t>(image.scratch.data(), image.pixels.data(), count);
    }
  }
  return std::nullopt;
}

}  // namespace polhode::platform
