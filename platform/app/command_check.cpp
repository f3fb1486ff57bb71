#include "app/command_check.hpp"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstddef>
#include <string>

#include "bus/commands.hpp"
#include "errors.hpp"
#include "pipeline/parameter_image.hpp"

namespace polhode::platform {
namespace {

std::string with_unit(std::string range, std::string_view unit) {
  return unit.empty() ? range : fmt::format("{} {}", range, unit);
}

std::string values_text(const bus::Field& field, const void* arguments) {
  std::string text;
  for (std::size_t i = 0; i < field.count; ++i) {
    text += fmt::format("{}{}", i == 0 ? "" : ",", bus::value_of(field, arguments, i));
  }
  return text;
}

/// Allowed values, where each is in its range but they contradict each other.
std::string_view agreement(std::string_view field) {
  return field == "q_IC" ? "a quaternion whose norm is within 0.001 of 1"
                         : "another point than first_px";
}

/// @param name  of the argument that is refused.
[[noreturn]] void refuse_argument(const bus::Layout& layout,
                                  std::span<const std::uint8_t> octets,
                                  std::string_view name) {
  alignas(std::max_align_t) std::array<std::byte, bus::kStructOctetsMax> arguments{};
  bus::unpack_fields(layout, octets, arguments.data());
  for (const bus::Field& field : layout.fields) {
    if (field.name != name) {
      continue;
    }
    const bool in_range = bus::out_of_range(layout, arguments.data(), 0.0) == nullptr;
    const std::string range = with_unit(fmt::format("{} .. {}", field.low, field.high), field.unit);
    throw UnusableInput(fmt::format("command {}: {} = {}: allowed is {}",
                                    layout.name,
                                    name,
                                    values_text(field, arguments.data()),
                                    in_range ? agreement(name) : std::string_view(range)));
  }
  throw UnusableInput(fmt::format("command {}: {} is out of its range", layout.name, name));
}

/// The value as it was written.
std::string value_text(const ParameterRow& row, std::uint64_t bits) {
  return std::holds_alternative<Member<double>>(row.member)
             ? fmt::format("{}", std::bit_cast<double>(bits))
             : fmt::format("{}", static_cast<std::int64_t>(bits));
}

void check_entry(const bus::TableLoadEntry& entry) {
  const ParameterRow* row = find_parameter_by_crc(entry.key_crc);
  if (row == nullptr) {
    return;  // the component's checks differ from this program's
  }
  if (!may_change_in_flight(row->key)) {
    throw UnusableInput(fmt::format("command table_load: {}: does not change in flight", row->key));
  }
  if (entry.index >= value_count(*row)) {
    throw UnusableInput(fmt::format("command table_load: {}: {} values, allowed is {}",
                                    row->key,
                                    entry.index + 1,
                                    value_count(*row)));
  }
  Parameters scratch;
  if (!set_from_bits(*row, entry.index, entry.value, &scratch)) {
    throw UnusableInput(fmt::format("command table_load: {} = {}: allowed is {}",
                                    row->key,
                                    value_text(*row, entry.value),
                                    with_unit(range_text(*row), row->unit)));
  }
}

}  // namespace

void check_ranges(std::span<const std::uint8_t> octets, int apid_first) {
  bus::Command command;
  const bus::Refusal refusal = bus::read_command(octets, apid_first, &command);
  if (refusal.reason == bus::Rejection::kRange) {
    refuse_argument(*command.layout, octets, refusal.why);
  }
  const bool loads =
      refusal.reason == bus::Rejection::kNone && command.code == bus::CommandCode::kTableLoad;
  for (std::size_t i = 0; loads && i < command.entries; ++i) {
    check_entry(command.entry(i));
  }
}

}  // namespace polhode::platform
