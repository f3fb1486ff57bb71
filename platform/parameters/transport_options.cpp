#include "parameters/transport_options.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <utility>

#include "errors.hpp"
#include "input_text.hpp"
#include "transport/address.hpp"

namespace polhode::platform {
namespace {

constexpr const char* kText = "a text";
constexpr std::string_view kOwnStructureKey = "mask.file";

/// Place and name of a value, for messages.
struct Place {
  std::string source;
  std::string key;
};

[[noreturn]] void refuse(const Place& place, const char* allowed) {
  throw UnusableInput(fmt::format("{}: {}: allowed is {}", place.source, place.key, allowed));
}

std::string text_of(const toml::node& node, const Place& place) {
  const auto text = node.value_exact<std::string>();
  if (!text) {
    refuse(place, kText);
  }
  return *text;
}

std::string address_of(const toml::node& node, const Place& place) {
  std::string text = text_of(node, place);
  named(fmt::format("{}: {}", place.source, place.key), [&] { (void)parse_address(text); });
  return text;
}

/// A list of addresses, or one; an empty text is none.
std::vector<std::string> addresses_of(const toml::node& node, const Place& place) {
  std::vector<std::string> addresses;
  if (const toml::array* list = node.as_array()) {
    for (const toml::node& entry : *list) {
      addresses.push_back(address_of(entry, place));
    }
  } else if (!text_of(node, place).empty()) {
    addresses.push_back(address_of(node, place));
  }
  return addresses;
}

void take_value(const toml::node& node, const Place& place, TransportOptions& options) {
  CommandSettings& commands = options.transport.commands;
  if (place.key == "transport.send") {
    if (!node.is_array()) {
      refuse(place, "a list of addresses");
    }
    options.transport.send = addresses_of(node, place);
  } else if (place.key == "transport.receive") {
    options.transport.receive = addresses_of(node, place);
  } else if (place.key == "commands.key") {
    commands.key = text_of(node, place);
  } else if (place.key == "commands.window") {
    commands.window = text_of(node, place);
  } else if (place.key == "commands.unauthenticated") {
    const auto value = node.value_exact<bool>();
    if (!value) {
      refuse(place, "true or false");
    }
    commands.unauthenticated = *value;
  } else if (place.key == "commands.file") {
    options.commands_file = text_of(node, place);
  } else if (place.key == kOwnStructureKey) {
    options.own_structure_file = text_of(node, place);
  } else {
    throw UnusableInput(fmt::format(
        "{}: {}: unknown key; known are transport.send, transport.receive, commands.file, "
        "commands.key, commands.window, commands.unauthenticated",
        place.source,
        place.key));
  }
}

void take_table(const toml::table& table, const std::string& source, TransportOptions& options) {
  for (const auto& [section, node] : table) {
    const toml::table* keys = node.as_table();
    if (keys == nullptr) {
      continue;
    }
    for (const auto& [field, value] : *keys) {
      const std::string key = fmt::format("{}.{}", section.str(), field.str());
      if (!is_transport_section(section.str()) && !is_transport_key(key)) {
        continue;
      }
      const bool in_file = source.rfind("--set", 0) != 0;
      const Place place{
          .source = in_file ? fmt::format("{}:{}", source, value.source().begin.line) : source,
          .key = key};
      take_value(value, place, options);
    }
  }
}

}  // namespace

bool is_transport_section(std::string_view section) {
  return section == "transport" || section == "commands";
}

bool is_transport_key(std::string_view key) { return key == kOwnStructureKey; }

TransportOptions load_transport_options(const std::filesystem::path& file,
                                        std::span<const std::string> settings) {
  TransportOptions options;
  std::string source = file.string();
  try {
    take_table(toml::parse(read_text(file, kSettingsBytesMax), source), source, options);
    for (const std::string& setting : settings) {
      source = fmt::format("--set {}", setting);
      take_table(toml::parse(setting), source, options);
    }
  } catch (const toml::parse_error& problem) {
    throw UnusableInput(fmt::format("{}: {}", source, problem.description()));
  }
  return options;
}

TransportOptions load_live_transport_options(const std::filesystem::path& file,
                                             std::span<const std::string> settings) {
  TransportOptions options = load_transport_options(file, settings);
  const std::string problem = problem_of(options.transport.receive, options.transport.commands);
  if (!problem.empty()) {
    throw UnusableInput(fmt::format("{}: {}", file.string(), problem));
  }
  return options;
}

std::string transport_table(const TransportOptions& options) {
  const TransportSettings& transport = options.transport;
  const std::pair<const char*, std::string> rows[] = {
      {"transport.send", fmt::format("{}", fmt::join(transport.send, ", "))},
      {"transport.receive", fmt::format("{}", fmt::join(transport.receive, ", "))},
      {"commands.file", options.commands_file.string()},
      {"commands.key", transport.commands.key.string()},
      {"commands.window", transport.commands.window.string()},
      {"commands.unauthenticated", fmt::format("{}", transport.commands.unauthenticated)},
      {kOwnStructureKey.data(), options.own_structure_file.string()}};
  std::string out;
  for (const auto& [key, value] : rows) {
    out += fmt::format("{:<32} {}\n", key, value.empty() ? "-" : value);
  }
  return out;
}

}  // namespace polhode::platform
