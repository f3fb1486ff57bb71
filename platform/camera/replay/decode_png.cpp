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
  Bytes file;
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

/// A row as it comes: pixels, places from one to the next in the image, channels.
struct Row {
  std::size_t count;
  std::size_t step;
  bool colour;
};

/// Luminance by ITU-R BT.601 in integers, weights in 1/65536: the same on every machine.
template <typename Sample>
Sample luminance(const std::uint8_t* colour) {
  Sample rgb[3];
  std::memcpy(rgb, colour, sizeof rgb);
  const std::uint64_t sum = 19595ULL * rgb[0] + 38470ULL * rgb[1] + 7471ULL * rgb[2];
  return static_cast<Sample>((sum + 32768ULL) >> 16U);
}

template <typename Sample>
void place_row(const std::uint8_t* from, const Row& row, std::uint8_t* to) {
  constexpr std::size_t kBytes = sizeof(Sample);
  if (!row.colour && row.step == 1) {
    std::memcpy(to, from, row.count * kBytes);
    return;
  }
  for (std::size_t i = 0; i < row.count; ++i) {
    Sample value;
    if (row.colour) {
      value = luminance<Sample>(from + 3 * i * kBytes);
    } else {
      std::memcpy(&value, from + i * kBytes, kBytes);
    }
    std::memcpy(to + i * row.step * kBytes, &value, kBytes);
  }
}

/// Owns libpng's structures for one pass over one file.
class Reader {
 public:
  explicit Reader(Bytes file) : source_{.file = file} {
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
    // Profiles and remarks would be unpacked into memory that nobody has planned.
    png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
    png_read_info(png_, info_);
    return true;
  }

  /// Requests 1 or 3 channels of 8 or 16 bits in the machine's byte order.
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
    png_read_update_info(png_, info_);
    return true;
  }

  /// Row by row, so that colour takes no more than one beside the image. An interlaced file has
  /// seven passes, each a smaller image of every eighth, fourth or second pixel.
  /// @param row     row_bytes() bytes, for one on its way
  /// @param pixels  height() rows of width() gray samples
  bool read_rows(std::uint8_t* row, std::uint8_t* pixels) {
    if (setjmp(png_jmpbuf(png_)) != 0) {
      return false;
    }
    const bool interlaced = png_get_interlace_type(png_, info_) != PNG_INTERLACE_NONE;
    for (int pass = 0; pass < (interlaced ? PNG_INTERLACE_ADAM7_PASSES : 1); ++pass) {
      const Pass part = interlaced ? part_of(pass) : Pass{.columns = width(), .rows = height()};
      for (png_uint_32 r = 0; part.columns > 0 && r < part.rows; ++r) {
        png_read_row(png_, row, nullptr);
        place(row, part, r, pixels);
      }
    }
    png_read_end(png_, nullptr);
    return true;
  }

  [[nodiscard]] png_uint_32 width() const { return png_get_image_width(png_, info_); }
  [[nodiscard]] png_uint_32 height() const { return png_get_image_height(png_, info_); }
  [[nodiscard]] bool deep() const { return png_get_bit_depth(png_, info_) == 16; }
  [[nodiscard]] bool colour() const { return png_get_channels(png_, info_) >= 3; }
  [[nodiscard]] std::size_t row_bytes() const { return png_get_rowbytes(png_, info_); }
  [[nodiscard]] std::string reason() const { return std::string("PNG: ") + source_.message; }

 private:
  /// Pixels of one pass: how many, and where.
  struct Pass {
    png_uint_32 columns = 0;
    png_uint_32 rows = 0;
    std::size_t first_column = 0;
    std::size_t first_row = 0;
    std::size_t column_step = 1;
    std::size_t row_step = 1;
  };

  [[nodiscard]] Pass part_of(int pass) const {
    return {.columns = PNG_PASS_COLS(width(), pass),
            .rows = PNG_PASS_ROWS(height(), pass),
            .first_column = static_cast<std::size_t>(PNG_PASS_START_COL(pass)),
            .first_row = static_cast<std::size_t>(PNG_PASS_START_ROW(pass)),
            .column_step = static_cast<std::size_t>(PNG_PASS_COL_OFFSET(pass)),
            .row_step = static_cast<std::size_t>(PNG_PASS_ROW_OFFSET(pass))};
  }

  void place(const std::uint8_t* row, const Pass& part, std::size_t r, std::uint8_t* pixels) const {
    const std::size_t first = (part.first_row + r * part.row_step) * width() + part.first_column;
    if (deep()) {
      place_row<std::uint16_t>(row, {part.columns, part.column_step, colour()}, pixels + 2 * first);
    } else {
      place_row<std::uint8_t>(row, {part.columns, part.column_step, colour()}, pixels + first);
    }
  }

  Source source_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

/// By the chunk sBIT, of the widest channel; 0: there is none. The library passes it over with all
/// that an image can do without.
int significant_bits(Bytes file) {
  constexpr std::size_t kAround = 12;  // length, type and checksum
  constexpr std::size_t kColours = 3;  // a fourth is alpha, as is a second
  std::size_t at = 8;                  // after the signature
  while (at + kAround < file.size()) {
    const std::size_t bytes = std::size_t{file[at]} << 24U | std::size_t{file[at + 1]} << 16U |
                              std::size_t{file[at + 2]} << 8U | file[at + 3];
    const Bytes type = file.subspan(at + 4, 4);
    if (std::memcmp(type.data(), "IDAT", 4) == 0 || bytes > file.size() - at - kAround) {
      return 0;
    }
    if (std::memcmp(type.data(), "sBIT", 4) == 0 && bytes > 0) {
      const Bytes bits = file.subspan(at + 8, bytes < kColours ? 1 : kColours);
      return *std::max_element(bits.begin(), bits.end());
    }
    at += bytes + kAround;
  }
  return 0;
}

}  // namespace

Refusal png_header(Bytes file, ImageHeader& header) {
  Reader reader(file);
  if (!reader.read_info()) {
    return reader.reason();
  }
  header = {.width_px = static_cast<int>(std::min<png_uint_32>(reader.width(), 1U << 30U)),
            .height_px = static_cast<int>(std::min<png_uint_32>(reader.height(), 1U << 30U)),
            .format = reader.deep() ? PixelFormat::kGray16 : PixelFormat::kGray8,
            .significant_bits = significant_bits(file)};
  return std::nullopt;
}

Refusal png_decode(Bytes file, DecodedImage& image) {
  Reader reader(file);
  if (!reader.read_info() || !reader.set_transformations()) {
    return reader.reason();
  }
  image.scratch.resize(reader.row_bytes());
  if (!reader.read_rows(image.scratch.data(), image.pixels.data())) {
    return reader.reason();
  }
  return std::nullopt;
}

}  // namespace polhode::platform
