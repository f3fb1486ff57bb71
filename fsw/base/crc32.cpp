#include <array>
#include <cstddef>

#include "base/crc.hpp"

namespace polhode {
namespace {

/// 0xEDB88320 is the polynomial 0x04C11DB7 with its bits reversed.
constexpr std::array<std::uint32_t, 256> make_crc32_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t remainder = byte;
    for (int bit = 0; bit < 8; ++bit) {
      remainder = (remainder & 1U) != 0 ? (remainder >> 1U) ^ 0xEDB88320U : remainder >> 1U;
    }
    table[byte] = remainder;
  }
  return table;
}

constexpr auto kCrc32Table = make_crc32_table();

}  // namespace

std::uint32_t crc32_iso_hdlc(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  std::uint32_t crc = ~before;
  for (const std::uint8_t byte : bytes) {
    crc = (crc >> 8U) ^ kCrc32Table[(crc ^ byte) & 0xFFU];
  }
  return ~crc;
}

}  // namespace polhode
