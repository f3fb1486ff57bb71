#include "bus/repeated_commands.hpp"

#include <algorithm>

#include "base/crc.hpp"
#include "bus/commands.hpp"
#include "bus/telemetry.hpp"

namespace polhode::bus {
namespace {

constexpr std::size_t kSequenceOctet = 2;     // of the primary header, CCSDS 133.0-B
constexpr std::uint16_t kCountBits = 0x3FFF;  // 14 bits, by the same

/// Checksum of the whole packet, its sequence count included. Never 0, the mark of an empty entry.
std::uint32_t identity(std::span<const std::uint8_t> octets) {
  return std::max<std::uint32_t>(crc32_iso_hdlc(octets), 1);
}

/// Rounded down, and modulo 2^32: it wraps after 136 years.
std::uint32_t seconds_of(std::int64_t time_ns) {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;  // a definition
  return static_cast<std::uint32_t>(time_ns / kSecond_ns - (time_ns % kSecond_ns < 0 ? 1 : 0));
}

bool is_recent(std::int64_t time_ns, const CommandsDone& done) {
  const std::uint32_t since = seconds_of(time_ns) - done.time_s;
  return since <= limits::kRepeat_s || 0U - since <= limits::kRepeat_s;
}

}  // namespace

std::uint16_t command_sequence(std::span<const std::uint8_t> octets) {
  return get_u16(octets, kSequenceOctet) & kCountBits;
}

std::uint16_t answered_sequence(std::span<const std::uint8_t> octets) {
  return octets.size() >= kCommandHeaderOctets + kCrcOctets && crc_is_right(octets)
             ? command_sequence(octets)
             : 0;
}

std::uint16_t next_command_sequence(std::uint16_t sequence) {
  return sequence >= kCountBits ? 1 : sequence + 1;
}

bool was_done(std::span<const std::uint8_t> octets,
              std::int64_t time_ns,
              const CommandsDone& done) {
  return command_sequence(octets) != 0 && is_recent(time_ns, done) &&
         std::find(done.crc.begin(), done.crc.end(), identity(octets)) != done.crc.end();
}

void remember(std::span<const std::uint8_t> octets, std::int64_t time_ns, CommandsDone* done) {
  if (command_sequence(octets) == 0) {
    return;
  }
  if (!is_recent(time_ns, *done)) {
    done->crc = {};
  }
  std::copy_backward(done->crc.begin(), done->crc.end() - 1, done->crc.end());
  done->crc.front() = identity(octets);
  done->time_s = seconds_of(time_ns);
}

}  // namespace polhode::bus
