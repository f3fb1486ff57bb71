#include "base/crc.hpp"

#include <array>
#include <cstddef>

namespace polhode {
namespace {

constexpr std::array<std::uint16_t, 256> make_crc16_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned remainder = byte << 8U;
    for (int bit = 0; bit < 8; ++bit) {
      remainder = (remainder & 0x8000U) != 0 ? (remainder << 1U) ^ 0x1021U : remainder << 1U;
    }
    table[byte] = static_cast<std::uint16_t>(remainder & 0xFFFFU);
  }
  return table;
}

constexpr auto kCrc16Table = make_crc16_table();

}  // namespace

std::uint16_t crc16_ccitt_false(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xFFFFU;
  for (const std::uint8_t byte : bytes) {
    const std::size_t index = ((crc >> 8U) ^ byte) & 0xFFU;
    crc = ((crc << 8U) ^ kCrc16Table[index]) & 0xFFFFU;
  }
  return static_cast<std::uint16_t>(crc);
}

}  // namespace polhode
