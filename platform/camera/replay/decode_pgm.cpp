// Binary PGM (P5), 8 and 16 bits: https://netpbm.sourceforge.net/doc/pgm.html
#include <cstddef>
#include <cstring>

#include "camera/replay/decode.hpp"

namespace polhode::platform {
namespace {

constexpr long kNumberMax = 1L << 30;

struct PgmHeader {
  long width = 0;
  long height = 0;
  long maxval = 0;
  std::size_t pixels_at = 0;
};

bool is_space(std::uint8_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// Skips blanks and comments, reads one decimal number. @return false at the end or at anything
/// else.
bool read_number(Bytes file, std::size_t& at, long& number) {
  while (at < file.size() && (is_space(file[at]) || file[at] == '#')) {
    if (file[at] == '#') {
      while (at < file.size() && file[at] != '\n') {
        ++at;
      }
    } else {
      ++at;
    }
  }
  const std::size_t first = at;
  number = 0;
  while (at < file.size() && file[at] >= '0' && file[at] <= '9' && number < kNumberMax) {
    number = number * 10 + (file[at] - '0');
    ++at;
  }
  return at > first;
}

Refusal parse(Bytes file, PgmHeader& header) {
  std::size_t at = 2;  // after "P5"
  if (!read_number(file, at, header.width) || !read_number(file, at, header.height) ||
      !read_number(file, at, header.maxval) || at >= file.size() || !is_space(file[at])) {
    return "PGM: header is not 'P5 width height maxval'";
  }
  if (header.width < 1 || header.width > kNumberMax || header.height < 1 ||
      header.height > kNumberMax) {
    return "PGM: width or height out of range, allowed 1 .. " + std::to_string(kNumberMax);
  }
  if (header.maxval < 1 || header.maxval > 65535) {
    return "PGM: maxval " + std::to_string(header.maxval) + " out of range, allowed 1 .. 65535";
  }
  header.pixels_at = at + 1;
  return std::nullopt;
}

}  // namespace

Refusal pgm_header(Bytes file, ImageHeader& header) {
  PgmHeader pgm;
  if (Refusal refusal = parse(file, pgm)) {
    return refusal;
  }
  header = {.width_px = static_cast<int>(pgm.width),
            .height_px = static_cast<int>(pgm.height),
            .format = pgm.maxval > 255 ? PixelFormat::kGray16 : PixelFormat::kGray8,
            .significant_bits = pgm.maxval > 255 && pgm.maxval < 65535 ? 16 : 0};
  return std::nullopt;
}

Refusal pgm_decode(Bytes file, DecodedImage& image) {
  PgmHeader pgm;
  if (Refusal refusal = parse(file, pgm)) {
    return refusal;
  }
  const Bytes raw = file.subspan(pgm.pixels_at);
  if (raw.size() < image.pixels.size()) {
    return "PGM: the file ends early";
  }
  const Bytes rest = raw.subspan(image.pixels.size());
  if (rest.size() > 2 && rest[0] == 'P' && rest[1] == '5' && is_space(rest[2])) {
    return "PGM: several pictures in one file; tools/import_sequence.py takes them apart";
  }
  // Brightness counts as a fraction of full scale later on, so a 10- or 12-bit camera's maxval
  // becomes full scale.
  const auto maxval = static_cast<std::uint32_t>(pgm.maxval);
  if (image.header.format == PixelFormat::kGray8) {
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      const std::uint32_t value = raw[i] < maxval ? raw[i] : maxval;
      image.pixels[i] = static_cast<std::uint8_t>((value * 255U + maxval / 2U) / maxval);
    }
    return std::nullopt;
  }
  for (std::size_t i = 0; i + 1 < image.pixels.size(); i += 2) {
    const std::uint32_t read = (std::uint32_t{raw[i]} << 8U) | raw[i + 1];
    const std::uint32_t value = read < maxval ? read : maxval;
    const auto scaled = static_cast<std::uint16_t>((value * 65535U + maxval / 2U) / maxval);
    std::memcpy(&image.pixels[i], &scaled, sizeof scaled);
  }
  return std::nullopt;
}

}  // namespace polhode::platform
