#include "app/command_check.hpp"

#include <fmt/format.h>

#include <string_view>

#include "bus/commands.hpp"
#include "errors.hpp"
#include "pipeline/parameter_image.hpp"

namespace polhode::platform {
namespace {

void check_entry(const bus::TableLoadEntry& entry) {
  const ParameterRow* row = find_parameter_by_crc(entry.key_crc);
  if (row == nullptr) {
    return;  // the component knows of others than this program
  }
  if (!may_change_in_flight(row->key)) {
    throw UnusableInput(fmt::format("command table_load: {}: does not change in flight", row->key));
  }
  Parameters scratch;
  if (!set_from_bits(*row, entry.index, entry.value, &scratch)) {
    throw UnusableInput(
        fmt::format("command table_load: {}: allowed is {}", row->key, range_text(*row)));
  }
}

}  // namespace

void check_ranges(std::span<const std::uint8_t> octets, int apid_first, std::string_view text) {
  bus::Command command;
  const bus::Refusal refusal = bus::read_command(octets, apid_first, &command);
  if (refusal.reason == bus::Rejection::kRange) {
    throw UnusableInput(fmt::format("command {}: {}: out of its range (docs/interface_control.md)",
                                    text,
                                    refusal.details.word));
  }
  const bool loads =
      refusal.reason == bus::Rejection::kNone && command.code == bus::CommandCode::kTableLoad;
  for (std::size_t i = 0; loads && i < command.entries; ++i) {
    check_entry(command.entry(i));
  }
}

}  // namespace polhode::platform
