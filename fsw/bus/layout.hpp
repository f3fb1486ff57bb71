// Layout of telemetry packets: CCSDS space packet header, CUC time, CRC, big-endian access.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "bus/packet_layout.hpp"

namespace polhode::bus {

// Header, 16 octets, so that the payload starts on a multiple of 8.
// Octets 0-5: CCSDS 133.0-B primary header. Octets 6-13: CUC time (CCSDS 301.0-B). 14: layout
// version. 15: time quality.
inline constexpr std::size_t kPrimaryHeaderOctets = 6;
inline constexpr std::size_t kHeaderOctets = 16;
inline constexpr std::size_t kCrcOctets = 2;
inline constexpr std::uint16_t kSequenceModulus = 0x4000;  ///< 2^14: the count has 14 bits
inline constexpr std::uint16_t kApidMax = 0x7FE;           ///< of 11 bits; 0x7FF is the idle packet

// CCSDS 133.0-B: the length field is the number of octets after the primary header, less 1.
inline constexpr std::size_t kLengthOffset = kPrimaryHeaderOctets + 1;
inline constexpr std::size_t kCcsdsOctetsMax = 0xFFFF + kLengthOffset;  ///< by its 16 bits

// CUC P-field: no extension, agency-defined epoch (code 010), 4 octets of seconds, 3 octets of
// 2^-24 s.
inline constexpr std::uint8_t kTimePField = 0x2F;

enum class TimeQuality : std::uint8_t {
  kCamera = 0,  ///< the camera's own time stamp
  kOutOfRange =
      1,  ///< the time stamp does not fit CUC (negative, or 2^32 s and more): the CUC field is zero
};

struct PacketHeader {
  std::uint16_t apid = 0;      ///< 0 .. 0x7FF
  std::uint16_t sequence = 0;  ///< 0 .. 0x3FFF
  std::size_t total_octets = 0;
  std::uint32_t seconds = 0;  ///< since 1970-01-01T00:00:00, as the camera's time stamps count
  std::uint32_t fraction_2_24 = 0;  ///< in units of 2^-24 s, under 2^24
  std::uint8_t layout_version = kLayoutVersion;
  TimeQuality time_quality = TimeQuality::kCamera;
};

/// The count after `sequence`; wraps at 14 bits.
[[nodiscard]] std::uint16_t next_sequence(std::uint16_t sequence);

/// Packets missing between two successively read counts of one APID, modulo 2^14.
[[nodiscard]] std::uint16_t packets_missing(std::uint16_t previous, std::uint16_t current);

/// CUC fields of a time stamp, rounded down to 2^-24 s (60 ns).
void set_time(std::int64_t timestamp_ns, PacketHeader* header);

/// Writes the 16 octets of `header`. `out` holds at least kHeaderOctets.
void write_header(const PacketHeader& header, std::span<std::uint8_t> out);

/// Reads and checks the fixed bits: version 0, telemetry, secondary header, unsegmented, P-field.
/// @return false when `in` is shorter than a header or a fixed bit differs; `header` is then
/// unspecified.
[[nodiscard]] bool read_header(std::span<const std::uint8_t> in, PacketHeader& header);

/// CRC-16/CCITT-FALSE of all but the last two octets, written into those.
void write_crc(std::span<std::uint8_t> packet);

/// @return true when the packet's last two octets are its checksum.
[[nodiscard]] bool crc_is_right(std::span<const std::uint8_t> packet);

// Big-endian access; `offset` plus the size must lie inside.
void put_u8(std::span<std::uint8_t> out, std::size_t offset, std::uint8_t value);
void put_u16(std::span<std::uint8_t> out, std::size_t offset, std::uint16_t value);
void put_u32(std::span<std::uint8_t> out, std::size_t offset, std::uint32_t value);
[[nodiscard]] std::uint8_t get_u8(std::span<const std::uint8_t> in, std::size_t offset);
[[nodiscard]] std::uint16_t get_u16(std::span<const std::uint8_t> in, std::size_t offset);
[[nodiscard]] std::uint32_t get_u32(std::span<const std::uint8_t> in, std::size_t offset);

}  // namespace polhode::bus
