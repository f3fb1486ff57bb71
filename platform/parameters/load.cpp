#include "parameters/load.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "errors.hpp"
#include "input_text.hpp"
#include "parameters/machine_options.hpp"
#include "parameters/suggest.hpp"
#include "parameters/transport_options.hpp"
#include "pipeline/parameter_table.hpp"

namespace polhode::platform {
namespace {

std::string toml_text(const toml::node& node) {
  std::ostringstream out;
  node.visit([&](const auto& value) { out << value; });
  return cited(out.str());
}

/// Writes a TOML value into a parameter. Each overload returns the allowed values, or nothing when
/// it fits.
struct Assign {
  const toml::node& node;
  Parameters& parameters;

  const char* operator()(Member<bool> where) const { return exact<bool>(where, "true or false"); }
  const char* operator()(Member<int> where) const {
    const auto value = node.value_exact<std::int64_t>();
    if (!value) {
      return "a whole number";
    }
    if (*value < INT32_MIN || *value > INT32_MAX) {
      return "a whole number of 32 bits";
    }
    where(parameters) = static_cast<int>(*value);
    return nullptr;
  }
  const char* operator()(Member<std::int64_t> where) const {
    return exact<std::int64_t>(where, "a whole number");
  }
  const char* operator()(Member<std::uint64_t> where) const {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || *value < 0) {
      return "a whole number, 0 or more";
    }
    where(parameters) = static_cast<std::uint64_t>(*value);
    return nullptr;
  }
  const char* operator()(Member<double> where) const {
    return number(node, where(parameters)) ? nullptr : "a number";
  }
  template <typename Choice>
  requires std::is_enum_v<Choice>
  const char* operator()(Member<Choice> where) const {
    const auto word = node.value_exact<std::string>();
    const auto& choices = choices_of(Choice{});
    const auto* const found = std::find(choices.begin(), choices.end(), word.value_or(""));
    if (found == choices.end()) {
      return "one of these words";
    }
    where(parameters) = static_cast<Choice>(found - choices.begin());
    return nullptr;
  }
  const char* operator()(Member<PointPair> where) const {
    const char* const allowed = "two points [[u, v], [u, v]]";
    const toml::array* pair = node.as_array();
    if (pair == nullptr || pair->size() != 2) {
      return allowed;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      const toml::array* point = pair->get(i)->as_array();
      if (point == nullptr || point->size() != 2 ||
          !number(*point->get(0), where(parameters)[i][0]) ||
          !number(*point->get(1), where(parameters)[i][1])) {
        return allowed;
      }
    }
    return nullptr;
  }

 private:
  static bool number(const toml::node& from, double& to) {
    const auto value = from.is_number() ? from.value<double>() : std::nullopt;
    to = value.value_or(to);
    return value.has_value();
  }
  template <typename T>
  const char* exact(Member<T> where, const char* allowed) const {
    const auto value = node.value_exact<T>();
    where(parameters) = value.value_or(where(parameters));
    return value ? nullptr : allowed;
  }
};

class Loader {
 public:
  Loader() { configuration_.origins.resize(parameter_table().size()); }

  void add_file(const std::filesystem::path& file) {
    try {
      const toml::table table = toml::parse(read_text(file, kSettingsBytesMax), file.string());
      if (table.empty()) {  // a full disk leaves such a file, and nobody means to fly by it
        throw UnusableInput(file.string() + ": is empty: it sets nothing");
      }
      add(table, file.string());
    } catch (const toml::parse_error& problem) {
      const toml::source_index line = problem.source().begin.line;
      const std::string where = line > 0 ? fmt::format(":{}", line) : std::string();
      throw UnusableInput(fmt::format("{}{}: {}", file.string(), where, problem.description()));
    }
  }

  void add_setting(const std::string& setting) {
    const std::string source = fmt::format("--set {}", setting);
    if (setting.find('\n') != std::string::npos || setting.find('=') == std::string::npos) {
      throw UnusableInput(fmt::format("{}: allowed is key=value", source));
    }
    try {
      add(toml::parse(setting), source);
    } catch (const toml::parse_error& problem) {
      throw UnusableInput(
          fmt::format("{}: {} (key=value, with a value as in TOML: text goes in "
                      "\"quotes\")",
                      source,
                      problem.description()));
    }
  }

  Configuration finish(const std::filesystem::path& file) {
    check_scale_is_whole(file);
    Parameters& parameters = configuration_.parameters;
    configuration_.has_camera = given("camera.width_px");
    const std::optional<Error> problem =
        given_any("camera.") ? check(parameters) : check_without_camera(parameters);
    if (problem) {
      throw UnusableInput(
          fmt::format("{}: {}", origin_of(problem->message, file), problem->message));
    }
    return configuration_;
  }

 private:
  void add(const toml::table& table, const std::string& source) {
    for (const auto& [key, node] : table) {
      const std::string name(key.str());
      const toml::table* section = node.as_table();
      if (section == nullptr) {
        assign(name, node, source);
        continue;
      }
      if (is_machine_section(name) || is_transport_section(name)) {
        continue;  // load_machine_options() and load_transport_options() read and check these
      }
      if (section->empty() && !is_section(name)) {
        unknown(name, node, source);
      }
      for (const auto& [field, value] : *section) {
        const std::string dotted = fmt::format("{}.{}", name, field.str());
        if (!is_transport_key(dotted)) {
          assign(dotted, value, source);
        }
      }
    }
  }

  void assign(const std::string& key, const toml::node& node, const std::string& source) {
    const ParameterRow* row = find_parameter(key);
    if (row == nullptr) {
      unknown(key, node, source);
    }
    const std::string where = position(node, source);
    const char* allowed =
        std::visit(Assign{.node = node, .parameters = configuration_.parameters}, row->member);
    if (allowed != nullptr) {
      throw UnusableInput(fmt::format("{}: {} = {}: wrong type, allowed is {} in {}",
                                      where,
                                      key,
                                      toml_text(node),
                                      allowed,
                                      range_text(*row)));
    }
    if (const auto problem = check_row(*row, configuration_.parameters)) {
      throw UnusableInput(fmt::format("{}: {}", where, problem->message));
    }
    origin(*row) = where;
  }

  [[noreturn]] static void unknown(const std::string& key,
                                   const toml::node& node,
                                   const std::string& source) {
    const std::string_view near = nearest_parameter(key);
    throw UnusableInput(fmt::format("{}: {}: unknown key{}",
                                    position(node, source),
                                    cited(key),
                                    near.empty()
                                        ? "; `polhode check --defaults` lists the known ones"
                                        : fmt::format("; did you mean {}?", near)));
  }

  /// Half of a length or of a range would leave the scale to guessing.
  void check_scale_is_whole(const std::filesystem::path& file) {
    const bool length = given("scale.known_length_m") || given("scale.points_px");
    const bool range = given("scale.range_m");
    const auto need = [&](const char* key, const char* with) {
      if (!given(key)) {
        throw UnusableInput(
            fmt::format("{}: {} is missing, it goes with {}", file.string(), key, with));
      }
    };
    if (length) {
      need("scale.known_length_m", "scale.points_px");
      need("scale.points_px", "scale.known_length_m");
      need("scale.frame_timestamp_ns", "scale.known_length_m");
    }
    if (given("scale.range_sigma_m")) {
      need("scale.range_m", "scale.range_sigma_m");
    }
    if (range) {
      need("scale.frame_timestamp_ns", "scale.range_m");
    } else if (!length && given("scale.frame_timestamp_ns")) {
      need("scale.known_length_m", "scale.frame_timestamp_ns");
    }
  }

  /// Messages of a whole-table check start with the key: the line that set it is the place to look.
  std::string origin_of(const std::string& message, const std::filesystem::path& file) const {
    const ParameterRow* row = find_parameter(message.substr(0, message.find(' ')));
    const std::string where = row == nullptr ? std::string() : origin(*row);
    return where.empty() ? file.string() : where;
  }

  static std::string position(const toml::node& node, const std::string& source) {
    const bool in_file = source.rfind("--set", 0) != 0 && node.source().begin.line > 0;
    return in_file ? fmt::format("{}:{}", source, node.source().begin.line) : source;
  }
  static bool is_section(const std::string& name) {
    for (const ParameterRow& row : parameter_table()) {
      if (row.key.substr(0, row.key.find('.')) == name && row.key != name) {
        return true;
      }
    }
    return false;
  }
  std::string& origin(const ParameterRow& row) {
    return configuration_.origins[static_cast<std::size_t>(&row - parameter_table().data())];
  }
  const std::string& origin(const ParameterRow& row) const {
    return configuration_.origins[static_cast<std::size_t>(&row - parameter_table().data())];
  }
  bool given(const char* key) const { return !origin(*find_parameter(key)).empty(); }
  bool given_any(std::string_view section) const {
    for (const ParameterRow& row : parameter_table()) {
      if (row.key.substr(0, section.size()) == section && !origin(row).empty()) {
        return true;
      }
    }
    return false;
  }

  Configuration configuration_;
};

}  // namespace

Configuration load_configuration(const std::filesystem::path& file,
                                 std::span<const std::string> settings) {
  Loader loader;
  loader.add_file(file);
  for (const std::string& setting : settings) {
    loader.add_setting(setting);
  }
  return loader.finish(file);
}

std::string canonical_text(const Parameters& parameters) {
  std::string text;
  for (const ParameterRow& row : parameter_table()) {
    const bool scale = row.key.substr(0, 6) == "scale.";
    const bool camera = row.key.substr(0, 7) == "camera.";
    if ((scale && !any_given(parameters.scale)) || (camera && parameters.camera.width_px == 0)) {
      continue;
    }
    text += fmt::format("{} = {}\n", row.key, value_text(row, parameters));
  }
  return text;
}

}  // namespace polhode::platform
