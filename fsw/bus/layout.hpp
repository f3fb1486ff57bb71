// Octets of the packets: CCSDS space packet header, CUC time, field offsets, big-endian pack and
// unpack.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace polhode::bus {

// Header, 16 octets, so that the payload starts on a multiple of 8.
// Octets 0-5: CCSDS 133.0-B primary header. Octets 6-13: CUC time (CCSDS 301.0-B). 14: layout
// version. 15: time quality.
inline constexpr std::size_t kPrimaryHeaderOctets = 6;
inline constexpr std::size_t kHeaderOctets = 16;
inline constexpr std::size_t kCrcOctets = 2;
inline constexpr std::uint8_t kLayoutVersion =
    1;  ///< a change of any packet's layout changes this and docs/bus.md
inline constexpr std::uint16_t kSequenceModulus = 0x4000;  ///< the 14-bit count wraps here
inline constexpr std::uint16_t kApidMax = 0x7FE;           ///< 0x7FF is the idle packet

// CUC P-field: no extension, agency-defined epoch (code 010), 4 octets of seconds, 3 octets of
// 2^-24 s.
inline constexpr std::uint8_t kTimePField = 0x2F;

enum class TimeQuality : std::uint8_t {
  kCamera = 0,  ///< the camera's own time stamp
  kOutOfRange =
      1,  ///< the time stamp does not fit CUC (negative, or 2^32 s and more): the CUC field is zero
};

/// Offsets of the motion packet from its first octet; every field starts on a multiple of its size.
namespace motion_layout {
inline constexpr std::size_t kTimestamp_ns = 16;        ///< int64
inline constexpr std::size_t kAttitude_q_CT = 24;       ///< 4 x float64: w, x, y, z
inline constexpr std::size_t kPosition_p_CT = 56;       ///< 3 x float64
inline constexpr std::size_t kVelocity_v_C = 80;        ///< 3 x float64
inline constexpr std::size_t kRate_w_T_rad_s = 104;     ///< 3 x float64
inline constexpr std::size_t kSigmaAttitude_rad = 128;  ///< float64
inline constexpr std::size_t kSigmaPosition = 136;      ///< float64
inline constexpr std::size_t kSigmaVelocity = 144;      ///< float64
inline constexpr std::size_t kSigmaRate_rad_s = 152;    ///< float64
inline constexpr std::size_t kFrame = 160;              ///< uint32
inline constexpr std::size_t kFeatures = 164;           ///< uint16
inline constexpr std::size_t kMatches = 166;            ///< uint16
inline constexpr std::size_t kInliers = 168;            ///< uint16
inline constexpr std::size_t kLandmarks = 170;          ///< uint16
inline constexpr std::size_t kKeyframes = 172;          ///< uint16
inline constexpr std::size_t kMode = 174;               ///< uint8
inline constexpr std::size_t kFlags = 175;              ///< uint8
inline constexpr std::size_t kCrc = 176;                ///< uint16 over octets 0 .. 175
inline constexpr std::size_t kPacketOctets = 178;

inline constexpr std::uint8_t kFlagPose = 0x01;
inline constexpr std::uint8_t kFlagRate = 0x02;
inline constexpr std::uint8_t kFlagVelocity = 0x04;
inline constexpr std::uint8_t kFlagScale = 0x08;
inline constexpr std::uint8_t kFlagsUsed = 0x0F;
}  // namespace motion_layout

static_assert(motion_layout::kTimestamp_ns == kHeaderOctets);
static_assert(motion_layout::kPacketOctets == motion_layout::kCrc + kCrcOctets);

struct PacketHeader {
  std::uint16_t apid = 0;      ///< 0 .. 0x7FF
  std::uint16_t sequence = 0;  ///< 0 .. 0x3FFF
  std::size_t total_octets = 0;
  std::uint32_t seconds = 0;  ///< since 1970-01-01T00:00:00, as the camera's time stamps count
  std::uint32_t fraction_2_24 = 0;  ///< in units of 2^-24 s, under 2^24
  std::uint8_t layout_version = kLayoutVersion;
  TimeQuality time_quality = TimeQuality::kCamera;
};

/// The count after `sequence`: counts always, wraps at 14 bits.
[[nodiscard]] std::uint16_t next_sequence(std::uint16_t sequence);

/// Packets missing between two counts of one APID that were read one after the other, modulo 2^14.
[[nodiscard]] std::uint16_t packets_missing(std::uint16_t previous, std::uint16_t current);

/// CUC fields of a time stamp, rounded down to 2^-24 s (60 ns).
void set_time(std::int64_t timestamp_ns, PacketHeader& header);

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
void put_i64(std::span<std::uint8_t> out, std::size_t offset, std::int64_t value);
void put_f64(std::span<std::uint8_t> out,
             std::size_t offset,
             double value);  ///< value must be finite
[[nodiscard]] std::uint8_t get_u8(std::span<const std::uint8_t> in, std::size_t offset);
[[nodiscard]] std::uint16_t get_u16(std::span<const std::uint8_t> in, std::size_t offset);
[[nodiscard]] std::uint32_t get_u32(std::span<const std::uint8_t> in, std::size_t offset);
[[nodiscard]] std::int64_t get_i64(std::span<const std::uint8_t> in, std::size_t offset);
[[nodiscard]] double get_f64(std::span<const std::uint8_t> in, std::size_t offset);

}  // namespace polhode::bus
