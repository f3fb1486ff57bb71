#include "bus/layout.hpp"

#include <limits>

#include "base/assert.hpp"
#include "base/crc.hpp"
#include "bus/octets.hpp"

namespace polhode::bus {
namespace {

static_assert(std::numeric_limits<double>::is_iec559 && sizeof(double) == 8);

constexpr std::int64_t kNanosecondsPerSecond = 1'000'000'000;  // by definition

}  // namespace

std::uint16_t next_sequence(std::uint16_t sequence) {
  return static_cast<std::uint16_t>((sequence + 1U) % kSequenceModulus);
}

std::uint16_t packets_missing(std::uint16_t previous, std::uint16_t current) {
  return static_cast<std::uint16_t>((current + 2U * kSequenceModulus - previous - 1U) %
                                    kSequenceModulus);
}

void set_time(std::int64_t timestamp_ns, PacketHeader* header) {
  const std::int64_t seconds = timestamp_ns / kNanosecondsPerSecond;
  header->seconds = 0;
  header->fraction_2_24 = 0;
  header->time_quality = TimeQuality::kOutOfRange;
  if (timestamp_ns < 0 || seconds > std::numeric_limits<std::uint32_t>::max()) {
    return;
  }
  const std::int64_t rest_ns = timestamp_ns % kNanosecondsPerSecond;
  header->seconds = static_cast<std::uint32_t>(seconds);
  header->fraction_2_24 = static_cast<std::uint32_t>((rest_ns << 24U) / kNanosecondsPerSecond);
  header->time_quality = TimeQuality::kCamera;
}

void write_header(const PacketHeader& header, std::span<std::uint8_t> out) {
  POLHODE_ASSERT(header.apid <= 0x7FFU, header.apid);
  POLHODE_ASSERT(header.total_octets > kHeaderOctets && header.total_octets <= kCcsdsOctetsMax,
                 header.total_octets);
  // Version 000, type 0 (telemetry), secondary header 1, APID. Then segmentation 11 (whole), count.
  // Then the length.
  put_u16(out, 0, static_cast<std::uint16_t>(0x0800U | header.apid));
  put_u16(out, 2, static_cast<std::uint16_t>(0xC000U | (header.sequence % kSequenceModulus)));
  put_u16(out, 4, static_cast<std::uint16_t>(header.total_octets - kLengthOffset));
  put_u8(out, 6, kTimePField);
  put_u32(out, 7, header.seconds);
  put_unsigned(out, 11, header.fraction_2_24, 3);
  put_u8(out, 14, header.layout_version);
  put_u8(out, 15, static_cast<std::uint8_t>(header.time_quality));
}

bool read_header(std::span<const std::uint8_t> in, PacketHeader& header) {
  if (in.size() < kHeaderOctets) {
    return false;
  }
  const unsigned identification = get_u16(in, 0);
  const unsigned control = get_u16(in, 2);
  const unsigned quality = get_u8(in, 15);
  if ((identification & 0xF800U) != 0x0800U || (control & 0xC000U) != 0xC000U ||
      get_u8(in, 6) != kTimePField || quality > static_cast<unsigned>(TimeQuality::kOutOfRange)) {
    return false;
  }
  header.apid = static_cast<std::uint16_t>(identification & 0x7FFU);
  header.sequence = static_cast<std::uint16_t>(control & 0x3FFFU);
  header.total_octets = get_u16(in, 4) + kLengthOffset;
  header.seconds = get_u32(in, 7);
  header.fraction_2_24 = static_cast<std::uint32_t>(get_unsigned(in, 11, 3));
  header.layout_version = get_u8(in, 14);
  header.time_quality = static_cast<TimeQuality>(quality);
  return header.total_octets > kHeaderOctets + kCrcOctets;
}

void write_crc(std::span<std::uint8_t> packet) {
  POLHODE_ASSERT(packet.size() > kCrcOctets, packet.size());
  const std::size_t end = packet.size() - kCrcOctets;
  put_u16(packet, end, crc16_ccitt_false(packet.first(end)));
}

bool crc_is_right(std::span<const std::uint8_t> packet) {
  return packet.size() > kCrcOctets && crc16_ccitt_false(packet) == 0;
}

void put_u8(std::span<std::uint8_t> out, std::size_t offset, std::uint8_t value) {
  put_unsigned(out, offset, value, 1);
}
void put_u16(std::span<std::uint8_t> out, std::size_t offset, std::uint16_t value) {
  put_unsigned(out, offset, value, 2);
}
void put_u32(std::span<std::uint8_t> out, std::size_t offset, std::uint32_t value) {
  put_unsigned(out, offset, value, 4);
}
std::uint8_t get_u8(std::span<const std::uint8_t> in, std::size_t offset) {
  return static_cast<std::uint8_t>(get_unsigned(in, offset, 1));
}
std::uint16_t get_u16(std::span<const std::uint8_t> in, std::size_t offset) {
  return static_cast<std::uint16_t>(get_unsigned(in, offset, 2));
}
std::uint32_t get_u32(std::span<const std::uint8_t> in, std::size_t offset) {
  return static_cast<std::uint32_t>(get_unsigned(in, offset, 4));
}

}  // namespace polhode::bus
