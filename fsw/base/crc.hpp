// CRC-16/CCITT-FALSE: polynomial 0x1021, initial value 0xFFFF, no reflection, check value 0x29B1.
#pragma once

#include <cstdint>
#include <span>

namespace polhode {

/// @return the checksum of `octets`; over a message followed by its own checksum (big-endian) it is 0.
std::uint16_t crc16_ccitt_false(std::span<const std::uint8_t> octets);

}  // namespace polhode
