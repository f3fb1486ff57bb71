// Big-endian whole numbers in octets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/assert.hpp"

namespace polhode::bus {

/// The `octets` (1 .. 8) low octets of `value`, most significant first. They must lie inside `out`.
inline void put_unsigned(std::span<std::uint8_t> out,
                         std::size_t offset,
                         std::uint64_t value,
                         std::size_t octets) {
  POLHODE_ASSERT(offset + octets <= out.size(), offset);
  for (std::size_t i = 0; i < octets; ++i) {
    out[offset + i] = static_cast<std::uint8_t>((value >> (8U * (octets - 1U - i))) & 0xFFU);
  }
}

inline std::uint64_t get_unsigned(std::span<const std::uint8_t> in,
                                  std::size_t offset,
                                  std::size_t octets) {
  POLHODE_ASSERT(offset + octets <= in.size(), offset);
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < octets; ++i) {
    value = (value << 8U) | in[offset + i];
  }
  return value;
}

}  // namespace polhode::bus
