#include "bus/repeated_commands.hpp"

#include <algorithm>

#include "base/crc.hpp"
#include "bus/telemetry.hpp"

namespace polhode::bus {
namespace {

constexpr std::size_t kSequenceOctet = 2;     // of the primary header, CCSDS 133.0-B
constexpr std::uint16_t kCountBits = 0x3FFF;  // 14 bits, by the same

/// Of the whole packet, its sequence count included. Never 0, which stands for none.
std::uint32_t identity(std::span<const std::uint8_t> octets) {
  return std::max<std::uint32_t>(crc32_iso_hdlc(octets), 1);
}

bool is_recent(std::uint32_t frame, const CommandsDone& done) {
  return frame - done.frame <= limits::kRepeatFrames;
}

}  // namespace

std::uint16_t command_sequence(std::span<const std::uint8_t> octets) {
  return get_u16(octets, kSequenceOctet) & kCountBits;
}

std::uint16_t next_command_sequence(std::uint16_t sequence) {
  return sequence >= kCountBits ? 1 : sequence + 1;
}

bool was_done(std::span<const std::uint8_t> octets, std::uint32_t frame, const CommandsDone& done) {
  return command_sequence(octets) != 0 && is_recent(frame, done) &&
         std::find(done.crc.begin(), done.crc.end(), identity(octets)) != done.crc.end();
}

void remember(std::span<const std::uint8_t> octets, std::uint32_t frame, CommandsDone* done) {
  if (command_sequence(octets) == 0) {
    return;
  }
  if (!is_recent(frame, *done)) {
    done->crc = {};
  }
  std::copy_backward(done->crc.begin(), done->crc.end() - 1, done->crc.end());
  done->crc.front() = identity(octets);
  done->frame = frame;
}

}  // namespace polhode::bus
