#include "recording/record.hpp"

#include <cstring>

#include "base/assert.hpp"
#include "base/crc.hpp"
#include "config/limits.hpp"

namespace polhode::platform {
namespace {

constexpr std::uint32_t kMagic = 0x31524850;  // "PHR1"
constexpr std::size_t kCrcAt = kRecordHeaderBytes - 4;

template <typename T>
void put(std::uint8_t*& at, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    *at++ = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i));
  }
}

template <typename T>
T take(const std::uint8_t*& at) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    value |= std::uint64_t{*at++} << (8 * i);
  }
  return static_cast<T>(value);
}

/// Kinds that exist, and an image of a size that a camera can have.
bool is_possible(const RecordHeader& header) {
  const bool kinds = header.kind >= RecordKind::kBegin && header.kind <= RecordKind::kCheckpoint &&
                     header.packing <= RecordPacking::kDifferenceLz4 &&
                     header.reason >= DropReason::kLate &&
                     header.reason <= DropReason::kNotRecorded;
  const bool has_image = header.kind == RecordKind::kFrame && header.readable;
  return kinds && (!has_image || (header.width_px > 0 && header.height_px > 0 &&
                                  header.width_px <= limits::kImageSide &&
                                  header.height_px <= limits::kImageSide));
}

}  // namespace

std::array<std::uint8_t, kRecordHeaderBytes> encode(const RecordHeader& header) {
  std::array<std::uint8_t, kRecordHeaderBytes> bytes{};
  std::uint8_t* at = bytes.data();
  put(at, kMagic);
  put(at, static_cast<std::uint8_t>(header.kind));
  put(at, static_cast<std::uint8_t>((header.readable ? 1U : 0U) | (header.deep ? 2U : 0U)));
  put(at, static_cast<std::uint8_t>(header.packing));
  put(at, static_cast<std::uint8_t>(header.reason));
  put(at, header.width_px);
  put(at, header.height_px);
  put(at, header.count);
  put(at, header.timestamp_ns);
  put(at, header.bytes);
  put(at, header.content_crc32);
  at = bytes.data() + kCrcAt;
  put(at, crc32_iso_hdlc(std::span(bytes).first(kCrcAt)));
  return bytes;
}

std::optional<RecordHeader> decode_record_header(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kRecordHeaderBytes) {
    return std::nullopt;
  }
  const std::uint8_t* at = bytes.data() + kCrcAt;
  if (take<std::uint32_t>(at) != crc32_iso_hdlc(bytes.first(kCrcAt))) {
    return std::nullopt;
  }
  at = bytes.data();
  if (take<std::uint32_t>(at) != kMagic) {
    return std::nullopt;
  }
  RecordHeader header;
  header.kind = static_cast<RecordKind>(take<std::uint8_t>(at));
  const auto flags = take<std::uint8_t>(at);
  header.readable = (flags & 1U) != 0;
  header.deep = (flags & 2U) != 0;
  header.packing = static_cast<RecordPacking>(take<std::uint8_t>(at));
  header.reason = static_cast<DropReason>(take<std::uint8_t>(at));
  header.width_px = take<std::uint16_t>(at);
  header.height_px = take<std::uint16_t>(at);
  header.count = take<std::uint32_t>(at);
  header.timestamp_ns = take<std::int64_t>(at);
  header.bytes = take<std::uint32_t>(at);
  header.content_crc32 = take<std::uint32_t>(at);
  return is_possible(header) ? std::optional(header) : std::nullopt;
}

void difference_rows(std::span<const std::uint8_t> from,
                     int width_px,
                     bool deep,
                     std::uint8_t* to) {
  const std::size_t pixel = deep ? 2 : 1;
  const std::size_t row = pixel * static_cast<std::size_t>(width_px);
  POLHODE_ASSERT(row > 0 && from.size() % row == 0, from.size());
  for (std::size_t start = 0; start < from.size(); start += row) {
    std::memcpy(to + start, from.data() + start, pixel);
    for (std::size_t i = start + pixel; i < start + row; ++i) {
      to[i] = static_cast<std::uint8_t>(from[i] - from[i - pixel]);  // byte by byte, modulo 256
    }
  }
}

void sum_rows(std::span<std::uint8_t> pixels, int width_px, bool deep) {
  const std::size_t pixel = deep ? 2 : 1;
  const std::size_t row = pixel * static_cast<std::size_t>(width_px);
  POLHODE_ASSERT(row > 0 && pixels.size() % row == 0, pixels.size());
  for (std::size_t start = 0; start < pixels.size(); start += row) {
    for (std::size_t i = start + pixel; i < start + row; ++i) {
      pixels[i] = static_cast<std::uint8_t>(pixels[i] + pixels[i - pixel]);
    }
  }
}

}  // namespace polhode::platform
