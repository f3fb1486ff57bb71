#include "parameters/bus_parameters.hpp"

#include <fmt/format.h>

#include <string_view>

#include "pipeline/parameter_image.hpp"

namespace polhode::platform {
namespace {

constexpr const char* kBusHead =
    "# The one field table of the bus: parameters that commands may change. See telemetry.toml.\n"
    "# Written by `polhode check --bus-parameters` from fsw/pipeline/parameter_table.cpp; a test "
    "keeps it so.\n"
    "#   type   of the value in a table_load's entry\n"
    "#   words  for the values 0, 1, ...\n";

bool is_real(const ParameterRow& row) { return std::holds_alternative<Member<double>>(row.member); }

/// Allowed values: a range of numbers, or words.
std::string allowed_line(const ParameterRow& row) {
  if (std::holds_alternative<Member<bool>>(row.member)) {
    return "words = [\"false\", \"true\"]";
  }
  const std::string text = range_text(row);
  const std::size_t between = text.find(" .. ");
  return between == std::string::npos
             ? fmt::format("words = [{}]", text)
             : fmt::format("range = [{}, {}]", text.substr(0, between), text.substr(between + 4));
}

}  // namespace

std::string bus_parameters() {
  const Parameters defaults;
  std::string out = kBusHead;
  for (const ParameterRow& row : parameter_table()) {
    if (!may_change_in_flight(row.key)) {
      continue;
    }
    out += fmt::format(
        "\n[[parameter]]\nkey = \"{}\"\ntype = \"{}\"\n{}\ndefault = {}\nunit = \"{}\"\nhelp = "
        "\"{}\"\n",
        row.key,
        is_real(row) ? "f64" : "i64",
        allowed_line(row),
        value_text(row, defaults),
        row.unit,
        row.help);
  }
  return out;
}

}  // namespace polhode::platform
