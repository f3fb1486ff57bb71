// Which commands have been carried out lately, so that one that comes twice is not carried out
// twice. A ground station sends a command again when its answer was lost.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "bus/capacities.hpp"

namespace polhode::bus {

/// Plain data.
struct CommandsDone {
  std::array<std::uint32_t, limits::kCommandsRemembered> crc{};  ///< of the latest first; 0: none
  std::uint32_t frame = 0;                                       ///< of the latest
};

/// The sequence count of a command's header, 0 .. 16383. 0: the sender does not count.
/// @param octets  a primary header at least.
std::uint16_t command_sequence(std::span<const std::uint8_t> octets);

/// The count after this one, 1 .. 16383.
std::uint16_t next_command_sequence(std::uint16_t sequence);

/// True for a command with a sequence count that was remembered with all its octets. Commands that
/// are older than limits::kRepeatFrames are forgotten: by then a sender may count from 1 again.
bool was_done(std::span<const std::uint8_t> octets, std::uint32_t frame, const CommandsDone& done);

/// Remembers a command with a sequence count. The oldest one leaves.
void remember(std::span<const std::uint8_t> octets, std::uint32_t frame, CommandsDone* done);

}  // namespace polhode::bus
