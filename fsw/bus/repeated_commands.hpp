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
  std::uint32_t time_s = 0;                                      ///< of the latest; modulo 2^32
};

/// The sequence count of a command's header, 0 .. 16383. 0: the sender does not count.
/// @param octets  a primary header at least.
std::uint16_t command_sequence(std::span<const std::uint8_t> octets);

/// The count after this one, 1 .. 16383.
std::uint16_t next_command_sequence(std::uint16_t sequence);

/// The sequence count for a command's answers; 0 if the octets are damaged.
/// @param octets  of any length.
std::uint16_t answered_sequence(std::span<const std::uint8_t> octets);

/// True for a command with a sequence count that was remembered with all its octets. Commands older
/// than limits::kRepeat_s do not count: by then a sender may count from 1 again.
/// @param time_ns  of the last frame, so that neither its rate nor a pause matters. Where a clock
/// was set back, by no more than that period, they are remembered for so much longer.
bool was_done(std::span<const std::uint8_t> octets, std::int64_t time_ns, const CommandsDone& done);

/// Remembers a command with a sequence count. The oldest one leaves.
void remember(std::span<const std::uint8_t> octets, std::int64_t time_ns, CommandsDone* done);

}  // namespace polhode::bus
