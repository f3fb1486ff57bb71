// Commands: CCSDS telecommand packets. Every octet is checked before anything is done.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "bus/events.hpp"
#include "bus/packets.hpp"

namespace polhode::bus {

// The primary header, layout version and function code.
inline constexpr std::size_t kCommandHeaderOctets = kPrimaryHeaderOctets + 2;

// A quaternion or direction that was written with three digits has its norm within this of 1; it is
// normalised before use.
inline constexpr double kNormTolerance = 1e-3;

/// A command whose length, header, CRC, code and ranges have been checked.
struct Command {
  CommandCode code = CommandCode::kNoop;
  const Layout* layout = nullptr;
  std::span<const std::uint8_t> octets;  ///< the whole packet
  std::size_t entries = 0;               ///< of a TABLE_LOAD

  /// The arguments, of the command's own struct.
  template <typename Arguments>
  [[nodiscard]] Arguments arguments() const {
    Arguments out;
    unpack_fields(Arguments::layout(), octets, &out);
    return out;
  }
  /// Entry `index` (under `entries`) of a TABLE_LOAD.
  [[nodiscard]] TableLoadEntry entry(std::size_t index) const;
  /// The octets of all entries.
  [[nodiscard]] std::span<const std::uint8_t> entry_octets() const;
};

/// Why a packet is not a command, or a command is not executed. Each member is valid for the
/// reasons named beside it.
struct Refusal {
  Rejection reason = Rejection::kNone;
  std::uint32_t octets = 0;           ///< kLength, kCrc: of the packet
  std::uint32_t octets_expected = 0;  ///< kLength
  std::uint8_t code = 0;              ///< kUnknownCode, kRange, kState: of the command
  std::string_view why{};             ///< kRange: the argument; kState: in words
  std::uint32_t beyond = 0;           ///< kTooMany: commands past limits::kStepCommands
};

/// Checks, in this order: the length that the header states is that of `octets`; version, type,
/// secondary header, APID, segmentation and layout version; CRC; function code; the length that the
/// command has; every argument's and entry's range.
/// @return Rejection::kNone, and the command; it refers to `octets`.
Refusal read_command(std::span<const std::uint8_t> octets, int apid_first, Command* command);

/// Reports a refusal by its event.
void report_refusal(const Refusal& refusal, EventLog* log);

}  // namespace polhode::bus
