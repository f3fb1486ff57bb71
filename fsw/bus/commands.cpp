#include "bus/commands.hpp"

#include <cmath>

#include "bus/event_reports.hpp"

namespace polhode::bus {
namespace {

constexpr std::size_t kShortest = kCommandHeaderOctets + kCrcOctets;
constexpr std::size_t kVersionOctet = kPrimaryHeaderOctets;
constexpr std::size_t kCodeOctet = kVersionOctet + 1;  // as the secondary header has them

bool header_is_right(std::span<const std::uint8_t> octets, int apid_first) {
  // Version 000, type 1 (telecommand), secondary header 1, APID. Segmentation 11: whole.
  const int identification = 0x1800 | (apid_first + kCommandApid);
  return get_u16(octets, 0) == identification && (get_u16(octets, 2) & 0xC000U) == 0xC000U &&
         get_u8(octets, kVersionOctet) == kLayoutVersion;
}

Refusal wrong_length(std::size_t is, std::size_t expected) {
  return {.reason = Rejection::kLength,
          .octets = static_cast<std::uint32_t>(is),
          .octets_expected = static_cast<std::uint32_t>(expected)};
}

/// The length that the command must have, by its own count of entries if it has any.
std::size_t exact_octets(CommandCode code, std::span<const std::uint8_t> octets) {
  const Layout& layout = *command_layouts()[static_cast<std::size_t>(code)];
  if (code != CommandCode::kTableLoad || octets.size() < layout.octets) {
    return layout.octets;
  }
  return layout.octets +
         get_u16(octets, table_load_layout::kEntries) * TableLoadEntry::layout().octets;
}

/// Values that are each in range but contradict each other. @return the field, or empty.
std::string_view contradiction(const Command& command) {
  if (command.code == CommandCode::kServicerAttitude) {
    const auto attitude = command.arguments<ServicerAttitudeCommand>();
    const auto& q = attitude.q_IC;
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return std::abs(norm - 1.0) > kNormTolerance ? "q_IC" : "";
  }
  if (command.code == CommandCode::kSetKnownLength) {
    const auto length = command.arguments<SetKnownLengthCommand>();
    return length.first_px == length.second_px ? "second_px" : "";
  }
  return {};
}

std::string_view bad_argument(const Command& command) {
  std::array<std::byte, kStructOctetsMax> arguments{};
  unpack_fields(*command.layout, command.octets, arguments.data());
  if (const Field* field = out_of_range(*command.layout, arguments.data(), 0.0)) {
    return field->name;
  }
  for (std::size_t i = 0; i < command.entries; ++i) {
    const TableLoadEntry entry = command.entry(i);
    if (const Field* field = out_of_range(TableLoadEntry::layout(), &entry, 0.0)) {
      return field->name;
    }
  }
  return contradiction(command);
}

}  // namespace

std::span<const std::uint8_t> Command::entry_octets() const {
  return octets.subspan(layout->octets - kCrcOctets, entries * TableLoadEntry::layout().octets);
}

TableLoadEntry Command::entry(std::size_t index) const {
  POLHODE_ASSERT(index < entries, index);
  const std::size_t size = TableLoadEntry::layout().octets;
  TableLoadEntry out;
  unpack_fields(TableLoadEntry::layout(), entry_octets().subspan(index * size, size), &out);
  return out;
}

Refusal read_command(std::span<const std::uint8_t> octets, int apid_first, Command* command) {
  if (octets.size() < kShortest) {
    return wrong_length(octets.size(), kShortest);
  }
  const std::size_t stated = get_u16(octets, 4) + kLengthOffset;
  if (stated != octets.size()) {
    return wrong_length(octets.size(), stated);
  }
  if (!header_is_right(octets, apid_first)) {
    return {.reason = Rejection::kHeader};
  }
  if (!crc_is_right(octets)) {
    return {.reason = Rejection::kCrc, .octets = static_cast<std::uint32_t>(octets.size())};
  }
  const std::uint8_t code = get_u8(octets, kCodeOctet);
  if (code >= command_layouts().size()) {
    return {.reason = Rejection::kUnknownCode, .code = code};
  }
  command->code = static_cast<CommandCode>(code);
  command->layout = command_layouts()[code];
  command->octets = octets;
  const std::size_t expected = exact_octets(command->code, octets);
  if (octets.size() != expected) {
    return wrong_length(octets.size(), expected);
  }
  command->entries = (expected - command->layout->octets) / TableLoadEntry::layout().octets;
  const std::string_view bad = bad_argument(*command);
  return bad.empty() ? Refusal{} : Refusal{.reason = Rejection::kRange, .code = code, .why = bad};
}

void report_refusal(const Refusal& refusal, EventLog* log) {
  const auto command = static_cast<CommandCode>(refusal.code);
  switch (refusal.reason) {
    case Rejection::kLength:
      return event::command_length({.octets = refusal.octets, .expected = refusal.octets_expected},
                                   log);
    case Rejection::kCrc:
      return event::command_crc({.octets = refusal.octets}, log);
    case Rejection::kUnknownCode:
      return event::command_unknown({.code = refusal.code}, log);
    case Rejection::kRange:
      return event::command_range({.command = command, .argument = refusal.why}, log);
    case Rejection::kState:
      return event::command_state({.command = command, .reason = refusal.why}, log);
    case Rejection::kTooMany:
      return event::command_too_many({.beyond = refusal.beyond, .limit = limits::kStepCommands},
                                     log);
    case Rejection::kNone:
    case Rejection::kHeader:
      return event::command_header(log);
  }
}

}  // namespace polhode::bus
