// Command packets as a ground station makes them, for tests.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bus/commands.hpp"

namespace polhode::bus {

using CommandOctets = std::vector<std::uint8_t>;

/// Header and CRC around arguments that are there already from octet 8 on.
inline void seal(CommandCode code, CommandOctets* octets, int apid_first = 0x1A0) {
  put_u16(*octets, 0, static_cast<std::uint16_t>(0x1800 | (apid_first + kCommandApid)));
  put_u16(*octets, 2, 0xC000);
  put_u16(*octets, 4, static_cast<std::uint16_t>(octets->size() - 7));
  put_u8(*octets, 6, kLayoutVersion);
  put_u8(*octets, 7, static_cast<std::uint8_t>(code));
  write_crc(*octets);
}

inline CommandOctets command(CommandCode code) {
  CommandOctets octets(kCommandHeaderOctets + kCrcOctets);
  seal(code, &octets);
  return octets;
}

template <typename Arguments>
CommandOctets command(CommandCode code, const Arguments& arguments) {
  CommandOctets octets(Arguments::layout().octets);
  pack_fields(Arguments::layout(), &arguments, octets);
  seal(code, &octets);
  return octets;
}

inline CommandOctets table_load(std::span<const TableLoadEntry> entries) {
  const std::size_t before = TableLoadCommand::layout().octets - kCrcOctets;
  const std::size_t size = TableLoadEntry::layout().octets;
  CommandOctets octets(before + entries.size() * size + kCrcOctets);
  TableLoadCommand head;
  head.entries = static_cast<std::uint16_t>(entries.size());
  pack_fields(TableLoadCommand::layout(), &head, octets);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    pack_fields(
        TableLoadEntry::layout(), &entries[i], std::span(octets).subspan(before + i * size, size));
  }
  seal(CommandCode::kTableLoad, &octets);
  return octets;
}

/// One good command of each code.
inline std::vector<CommandOctets> one_of_each() {
  const TableLoadEntry entry{.key_crc = 1, .value = 2};
  return {
      command(CommandCode::kNoop),
      command(CommandCode::kResetCounters),
      command(CommandCode::kResetMap),
      command(CommandCode::kHold),
      command(CommandCode::kResume),
      command(CommandCode::kSetKnownLength,
              SetKnownLengthCommand{.frame_timestamp_ns = 5,
                                    .length_m = 0.6,
                                    .first_px = {1.0, 2.0},
                                    .second_px = {30.0, 40.0}}),
      command(CommandCode::kSetRange, SetRangeCommand{.frame_timestamp_ns = 5, .range_m = 12.0}),
      command(CommandCode::kServicerAttitude,
              ServicerAttitudeCommand{.timestamp_ns = 5, .q_IC = {1.0, 0.0, 0.0, 0.0}}),
      command(CommandCode::kRequestCloud, RequestCloudCommand{.points_max = 10}),
      table_load(std::span(&entry, 1)),
      command(CommandCode::kTableActivate, TableActivateCommand{.crc32 = 1, .entries = 1}),
      command(CommandCode::kTableDiscard),
      command(CommandCode::kCheckpoint),
      command(CommandCode::kPredictPoint,
              PredictPointCommand{.predicted_timestamp_ns = 2,
                                  .p_T = {0.1, 0.2, 0.3},
                                  .normal_T = {0.0, 0.0, 1.0},
                                  .target_frame = 1,
                                  .number = 7})};
}

}  // namespace polhode::bus
