// CRC-16/CCITT-FALSE: polynomial 0x1021, initial value 0xFFFF, no reflection, check value 0x29B1.
// CRC-32/ISO-HDLC (zlib's): polynomial 0x04C11DB7, reflected, check value 0xCBF43926.
#pragma once

#include <cstdint>
#include <span>

namespace polhode {

/// @return the checksum of `bytes`; 0 over a message followed by its own checksum (big-endian).
std::uint16_t crc16_ccitt_false(std::span<const std::uint8_t> bytes);

/// @param before  checksum of the message before `bytes`; 0 at its beginning.
std::uint32_t crc32_iso_hdlc(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

}  // namespace polhode
