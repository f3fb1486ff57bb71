#include "parameters/print.hpp"

#include <fmt/format.h>

#include "pipeline/parameter_table.hpp"

namespace polhode::platform {
namespace {

constexpr const char* kHead =
    "# Every parameter of the estimator with its default: allowed values, unit, what it does. "
    "Works as it is on any sequence;\n"
    "# lengths are then in map units. Copy what you change into a file of your own, or change "
    "single values with --set key=value.\n"
    "# Written by `polhode check --defaults`; a test keeps it so.\n";

constexpr const char* kScaleHead =
    "# For metres instead of map units, remove the # before what is known. A length and a range "
    "need the frame that they belong to.\n"
    "# Several are combined by their sigmas. Where they contradict each other, shape.json reports "
    "it and lengths stay in map units.\n";

constexpr const char* kCameraHead =
    "# A replay takes its camera from the sequence's sensor.yaml. This section is for a "
    "configuration without a sequence.\n";

constexpr const char* kMaskHead =
    "# file = \"own.png\" names a picture of what is the servicer's own in the view: PNG or PGM of "
    "the "
    "camera's size, white where it is seen.\n"
    "# Nothing there is target. It is read before the start; none by default.\n";

std::string section_of(std::string_view key) {
  const std::size_t dot = key.find('.');
  return std::string(dot == std::string_view::npos ? std::string_view() : key.substr(0, dot));
}

const char* head_of(std::string_view section) {
  return section == "scale"    ? kScaleHead
         : section == "camera" ? kCameraHead
         : section == "mask"   ? kMaskHead
                               : "";
}

/// Examples for keys that have no default.
std::string example(const ParameterRow& row) {
  Parameters sample;
  sample.scale = {.known_length_m = 0.6,
                  .points_px = {{{812.0, 400.5}, {1010.2, 377.9}}},
                  .range_m = 12.5,
                  .range_sigma_m = 0.05,
                  .frame_timestamp_ns = 1700000000000000000,
                  .known_diameter_m = 1.9,
                  .known_edge_m = 0.8};
  sample.camera = {.width_px = 1920,
                   .height_px = 1080,
                   .fu_px = 2000.0,
                   .fv_px = 2000.0,
                   .cu_px = 959.5,
                   .cv_px = 539.5};
  return value_text(row, sample);
}

std::string limits_text(const ParameterRow& row) {
  return row.unit.empty() ? range_text(row) : fmt::format("{} {}", range_text(row), row.unit);
}

}  // namespace

std::string effective_table(const Configuration& configuration) {
  std::string out = fmt::format("{:<32} {:<28} {:<40} {}\n", "key", "value", "allowed", "from");
  const Parameters& parameters = configuration.parameters;
  std::size_t index = 0;
  for (const ParameterRow& row : parameter_table()) {
    const std::string& origin = configuration.origins[index++];
    const bool absent = has_no_default(row.key) && origin.empty();
    out += fmt::format("{:<32} {:<28} {:<40} {}\n",
                       row.key,
                       absent ? "-" : value_text(row, parameters),
                       limits_text(row),
                       origin.empty() ? (absent ? "not given" : "default") : origin);
  }
  return out;
}

std::string documented_defaults() {
  const Parameters defaults;
  std::string out = kHead;
  std::string section;
  for (const ParameterRow& row : parameter_table()) {
    const std::string here = section_of(row.key);
    if (here != section) {
      section = here;
      out += fmt::format("\n[{}]\n", section);
      out += head_of(section);
    } else if (section.empty()) {
      out += "\n";
    }
    const std::string field(row.key.substr(row.key.find('.') + 1));
    const bool absent = has_no_default(row.key);
    const std::string line = fmt::format(
        "{}{} = {}", absent ? "# " : "", field, absent ? example(row) : value_text(row, defaults));
    out += fmt::format("{:<44} # {}; {}\n", line, limits_text(row), row.help);
  }
  return out;
}

}  // namespace polhode::platform
