#include "parameters/machine_options.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <variant>

#include "camera/v4l2/formats.hpp"
#include "errors.hpp"
#include "input_text.hpp"

namespace polhode::platform {
namespace {

template <typename T>
using Where = T& (*)(MachineOptions&);
using AnyWhere =
    std::variant<Where<std::string>, Where<int>, Where<std::int64_t>, Where<double>, Where<bool>>;

struct Row {
  std::string_view key;
  AnyWhere where;
  double low = 0.0;
  double high = 0.0;
};

#define POLHODE_OPTION(path)                                                                 \
  static_cast<Where<std::remove_reference_t<decltype((MachineOptions{}.path))>>>(            \
      [](MachineOptions& o) -> std::remove_reference_t<decltype((MachineOptions{}.path))>& { \
        return o.path;                                                                       \
      })

// clang-format off
const Row kRows[] = {
  {"device.source", POLHODE_OPTION(device.source)},
  {"device.pixel_format", POLHODE_OPTION(device.pixel_format)},
  {"device.rate_hz", POLHODE_OPTION(device.rate_hz), 0.01, 1000},
  {"device.buffers", POLHODE_OPTION(device.buffers), 2, 32},
  {"device.backlog_frames_max", POLHODE_OPTION(device.backlog_frames_max), 0, 32},
  {"device.silence_ms_max", POLHODE_OPTION(device.silence_ms_max), 50, 600000},
  {"device.exposure_us", POLHODE_OPTION(device.exposure_us), 0, 10000000},
  {"device.gain", POLHODE_OPTION(device.gain), -1, 1},
  {"device.exposure_control", POLHODE_OPTION(device.exposure_control)},
  {"device.gain_factor_max", POLHODE_OPTION(device.gain_factor_max), 1, 1000},
  {"device.readout_us", POLHODE_OPTION(device.readout_us), 0, 10000000},
  {"device.clock", POLHODE_OPTION(device.clock)},
  {"device.sequence_speed", POLHODE_OPTION(device.sequence_speed), 0, 1000},
  {"device.sequence_passes", POLHODE_OPTION(device.sequence_passes), 1, 100000},
  {"device.sequence_start_ns", POLHODE_OPTION(device.sequence_start_ns), 0, 4e18},
  {"run.folder", POLHODE_OPTION(run.folder)},
  {"run.checkpoint", POLHODE_OPTION(run.checkpoint)},
  {"run.model", POLHODE_OPTION(run.model)},
  {"run.checkpoint_frames", POLHODE_OPTION(run.checkpoint_frames), 1, 1000000},
  {"run.checkpoint_age_s_max", POLHODE_OPTION(run.checkpoint_age_s_max), 1, 1000000},
  {"run.start_s_max", POLHODE_OPTION(run.start_s_max), 0, 1000000},
  {"run.frames_max", POLHODE_OPTION(run.frames_max), 0, 2e9},
  {"run.report_s", POLHODE_OPTION(run.report_s), 1, 86400},
  {"run.lock_memory", POLHODE_OPTION(run.lock_memory)},
  {"run.core", POLHODE_OPTION(run.core), -1, 1023},
  {"run.priority", POLHODE_OPTION(run.priority), 0, 99},
  {"recording.folder", POLHODE_OPTION(recording.folder)},
  {"recording.disk_mb_max", POLHODE_OPTION(recording.disk_mb_max), 16, 100000000},
  {"recording.segment_mb", POLHODE_OPTION(recording.segment_mb), 1, 1000},
  {"recording.slots", POLHODE_OPTION(recording.slots), 2, 64},
  {"recording.complete", POLHODE_OPTION(recording.complete)},
};
// clang-format on
#undef POLHODE_OPTION

const Row* find_row(std::string_view key) {
  const auto* found =
      std::find_if(std::begin(kRows), std::end(kRows), [&](const Row& r) { return r.key == key; });
  return found == std::end(kRows) ? nullptr : found;
}

std::string range_text(const Row& row) {
  return row.low == row.high ? std::string() : fmt::format("{} .. {}", row.low, row.high);
}

/// Writes a TOML value into an option.
/// @return the allowed values, or nothing when it fits.
struct AssignOption {
  const toml::node& node;
  const Row& row;
  MachineOptions& options;

  std::string operator()(Where<std::string> where) const { return exact(where, "a text"); }
  std::string operator()(Where<bool> where) const { return exact(where, "true or false"); }
  std::string operator()(Where<int> where) const {
    return number(where, node.value_exact<std::int64_t>());
  }
  std::string operator()(Where<std::int64_t> where) const {
    return number(where, node.value_exact<std::int64_t>());
  }
  std::string operator()(Where<double> where) const {
    return number(where, node.is_number() ? node.value<double>() : std::nullopt);
  }

 private:
  template <typename T>
  std::string exact(Where<T> where, const char* allowed) const {
    const auto value = node.value_exact<T>();
    where(options) = value.value_or(where(options));
    return value ? "" : allowed;
  }
  template <typename T, typename Value>
  std::string number(Where<T> where, const std::optional<Value>& value) const {
    // false for NaN
    if (!value ||
        !(static_cast<double>(*value) >= row.low && static_cast<double>(*value) <= row.high)) {
      return fmt::format(
          "{} {}", std::is_same_v<T, double> ? "a number" : "a whole number", range_text(row));
    }
    where(options) = static_cast<T>(*value);
    return "";
  }
};

std::string option_text(const toml::node& node) {
  std::ostringstream out;
  node.visit([&](const auto& value) { out << value; });
  return out.str();
}

void take_table(const toml::table& table, const std::string& source, MachineOptions* options) {
  for (const auto& [section, node] : table) {
    const toml::table* keys = node.as_table();
    if (keys == nullptr || !is_machine_section(section.str())) {
      continue;
    }
    for (const auto& [field, value] : *keys) {
      const std::string key = fmt::format("{}.{}", section.str(), field.str());
      const bool in_file = source.rfind("--set", 0) != 0;
      const std::string where =
          in_file ? fmt::format("{}:{}", source, value.source().begin.line) : source;
      const Row* row = find_row(key);
      if (row == nullptr) {
        throw UnusableInput(fmt::format("{}: {}: unknown key", where, key));
      }
      const std::string allowed =
          std::visit(AssignOption{.node = value, .row = *row, .options = *options}, row->where);
      if (!allowed.empty()) {
        throw UnusableInput(
            fmt::format("{}: {} = {}: allowed is {}", where, key, option_text(value), allowed));
      }
    }
  }
}

void check_texts(const MachineOptions& options, const std::filesystem::path& file) {
  const DeviceOptions& device = options.device;
  if (device.clock != "monotonic" && device.clock != "utc") {
    throw UnusableInput(fmt::format("{}: device.clock = \"{}\": allowed are \"monotonic\", \"utc\"",
                                    file.string(),
                                    device.clock));
  }
  if (device.pixel_format != "auto" && find_packing(device.pixel_format) == nullptr) {
    std::string allowed = "\"auto\"";
    for (const PixelPacking& packing : pixel_packings()) {
      allowed += fmt::format(", \"{}\"", packing.name);
    }
    throw UnusableInput(fmt::format("{}: device.pixel_format = \"{}\": allowed are {}",
                                    file.string(),
                                    device.pixel_format,
                                    allowed));
  }
  if (static_cast<double>(device.silence_ms_max) * device.rate_hz < 2000.0) {
    throw UnusableInput(
        fmt::format("{}: device.silence_ms_max = {}: at device.rate_hz = {} a frame comes every {} "
                    "ms; allowed is twice that and more",
                    file.string(),
                    device.silence_ms_max,
                    device.rate_hz,
                    std::lround(1000.0 / device.rate_hz)));
  }
}

}  // namespace

bool is_machine_section(std::string_view section) {
  return std::any_of(std::begin(kRows), std::end(kRows), [&](const Row& row) {
    return row.key.substr(0, row.key.find('.')) == section;
  });
}

MachineOptions load_machine_options(const std::filesystem::path& file,
                                    std::span<const std::string> settings) {
  MachineOptions options;
  std::string source = file.string();
  try {
    take_table(toml::parse(read_text(file, kSettingsBytesMax), source), source, &options);
    for (const std::string& setting : settings) {
      source = fmt::format("--set {}", setting);
      take_table(toml::parse(setting), source, &options);
    }
  } catch (const toml::parse_error& problem) {
    throw UnusableInput(fmt::format("{}: {}", source, problem.description()));
  }
  check_texts(options, file);
  return options;
}

std::string machine_table(const MachineOptions& options) {
  MachineOptions copy = options;  // reached through a mutable reference only
  std::string out;
  for (const Row& row : kRows) {
    const std::string value =
        std::visit([&](auto where) { return fmt::format("{}", where(copy)); }, row.where);
    out += fmt::format("{:<32} {:<28} {}\n", row.key, value.empty() ? "-" : value, range_text(row));
  }
  return out;
}

std::vector<std::string> machine_keys() {
  std::vector<std::string> keys;
  for (const Row& row : kRows) {
    keys.emplace_back(row.key);
  }
  return keys;
}

}  // namespace polhode::platform
