#include "transport/command_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstring>
#include <optional>

#include "base/crc.hpp"
#include "bus/commands.hpp"
#include "bus/octets.hpp"
#include "bus/repeated_commands.hpp"
#include "errors.hpp"
#include "pipeline/parameter_image.hpp"

namespace polhode::platform {
namespace {

using Octets = std::vector<std::uint8_t>;
using bus::FieldType;

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> words;
  while (!text.empty()) {
    const std::size_t end = text.find(at);
    if (end != 0) {
      words.push_back(text.substr(0, end));
    }
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return words;
}

template <typename T>
std::optional<T> number(std::string_view text, int base = 10) {
  T value{};
  std::from_chars_result end{};
  if constexpr (std::is_floating_point_v<T>) {
    end = std::from_chars(text.data(), text.data() + text.size(), value);
  } else {
    end = std::from_chars(text.data(), text.data() + text.size(), value, base);
  }
  const bool whole = end.ec == std::errc{} && end.ptr == text.data() + text.size();
  return whole ? std::optional<T>(value) : std::nullopt;
}

/// Bits of a value as the wire has them.
std::optional<std::uint64_t> bits_of_text(FieldType type, std::string_view text) {
  if (type == FieldType::kF64) {
    const auto value = number<double>(text);
    return value ? std::optional(std::bit_cast<std::uint64_t>(*value)) : std::nullopt;
  }
  if (type == FieldType::kI64) {
    const auto value = number<std::int64_t>(text);
    return value ? std::optional(static_cast<std::uint64_t>(*value)) : std::nullopt;
  }
  const bool hex = text.starts_with("0x");
  const auto value = number<std::uint64_t>(hex ? text.substr(2) : text, hex ? 16 : 10);
  const std::size_t bits = 8 * bus::size_of(type);
  const bool fits = value && (bits == 64 || *value >> bits == 0);
  return fits ? value : std::nullopt;
}

std::string usage(const bus::Layout& layout) {
  std::string text(layout.name);
  for (const bus::Field& field : layout.fields) {
    if (field.name != "spare") {
      text += fmt::format(" {}={}", field.name, field.is_array ? "V,V,..." : "V");
    }
  }
  return text;
}

[[noreturn]] void refuse(const bus::Layout& layout, std::string_view what) {
  throw UnusableInput(fmt::format("command {}: {}; it is {}", layout.name, what, usage(layout)));
}

const bus::Layout& layout_of(std::string_view name) {
  std::string known;
  for (const bus::Layout* layout : bus::command_layouts()) {
    if (layout->name == name) {
      return *layout;
    }
    known += fmt::format(" {}", layout->name);
  }
  throw UnusableInput(fmt::format("command '{}': unknown; known are{}, hex", cited(name), known));
}

void put_field(const bus::Layout& layout,
               const bus::Field& field,
               std::string_view text,
               Octets& octets) {
  const auto values = split(text, ',');
  if (values.size() != field.count) {
    refuse(layout, fmt::format("{} has {} values", field.name, field.count));
  }
  const std::size_t size = bus::size_of(field.type);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto bits = bits_of_text(field.type, values[i]);
    if (!bits) {
      refuse(layout, fmt::format("{}={} is no number of its type", field.name, cited(text)));
    }
    bus::put_unsigned(octets, field.octet + i * size, *bits, size);
  }
}

Octets arguments(const bus::Layout& layout, const std::vector<std::string_view>& words) {
  Octets octets(layout.octets);
  std::size_t used = 1;
  for (const bus::Field& field : layout.fields) {
    if (field.name == "spare") {
      continue;
    }
    const std::string begin = fmt::format("{}=", field.name);
    std::size_t found = 0;
    for (std::size_t i = 1; i < words.size(); ++i) {
      if (words[i].starts_with(begin)) {
        put_field(layout, field, words[i].substr(begin.size()), octets);
        ++found;
      }
    }
    if (found != 1) {
      refuse(layout, fmt::format("{} is {}", field.name, found == 0 ? "missing" : "given twice"));
    }
    ++used;
  }
  if (used != words.size()) {
    refuse(layout, "there is an argument that it does not have");
  }
  return octets;
}

Octets octets_of_hex(std::string_view digits) {
  Octets octets(digits.size() / 2);
  for (std::size_t i = 0; i < octets.size(); ++i) {
    const auto value = number<std::uint8_t>(digits.substr(2 * i, 2), 16);
    if (!value || digits.size() % 2 != 0) {
      throw UnusableInput(
          fmt::format("command hex {}: not pairs of hexadecimal digits", cited(digits)));
    }
    octets[i] = *value;
  }
  return octets;
}

/// The code of a word that a parameter may be.
std::optional<std::uint64_t> code_of_word(const ParameterRow& row, std::string_view text) {
  const auto code = [text](const auto& words) -> std::optional<std::uint64_t> {
    const auto at = std::find(words.begin(), words.end(), text);
    return at != words.end() ? std::optional<std::uint64_t>(at - words.begin()) : std::nullopt;
  };
  if (std::holds_alternative<Member<bool>>(row.member)) {
    return code(std::array<std::string_view, 2>{"false", "true"});
  }
  if (std::holds_alternative<Member<MotionMode>>(row.member)) {
    return code(choices_of(MotionMode{}));
  }
  return std::holds_alternative<Member<DynamicsKind>>(row.member) ? code(choices_of(DynamicsKind{}))
                                                                  : std::nullopt;
}

/// Entries of one parameter: one a value.
void add_entries(std::string_view setting, Octets& entries) {
  const std::size_t equals = setting.find('=');
  const std::string_view key = setting.substr(0, equals);
  const ParameterRow* row = find_parameter(key);
  if (row == nullptr || equals == std::string_view::npos) {
    throw UnusableInput(fmt::format("command table_load: '{}': unknown parameter", cited(setting)));
  }
  const std::string_view text = setting.substr(equals + 1);
  const bool real = std::holds_alternative<Member<double>>(row->member) ||
                    std::holds_alternative<Member<PointPair>>(row->member);
  const auto values = split(text, ',');
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto word = code_of_word(*row, values[i]);
    const auto bits =
        word ? word : bits_of_text(real ? FieldType::kF64 : FieldType::kI64, values[i]);
    if (!bits) {
      throw UnusableInput(fmt::format("command table_load: {} = {}: allowed are {}",
                                      row->key,
                                      cited(values[i]),
                                      range_text(*row)));
    }
    const std::size_t at = entries.size();
    entries.resize(at + bus::TableLoadEntry::layout().octets);
    bus::put_unsigned(entries, at, key_crc(key), 4);
    bus::put_unsigned(entries, at + 4, i, 2);
    bus::put_unsigned(entries, at + 8, *bits, 8);
  }
}

}  // namespace

void CommandWriter::seal(std::uint8_t code, Octets& octets) {
  bus::put_unsigned(octets, 0, 0x1800U | static_cast<unsigned>(apid_first_ + bus::kCommandApid), 2);
  bus::put_unsigned(octets, 2, 0xC000U | sequence_, 2);
  const bool counts = sequence_ != 0;
  sequence_ = counts ? bus::next_command_sequence(sequence_) : sequence_;
  bus::put_unsigned(octets, 4, octets.size() - 7, 2);
  octets[6] = bus::kLayoutVersion;
  octets[7] = code;
  bus::write_crc(octets);
}

Octets CommandWriter::table_load(const std::vector<std::string_view>& words) {
  Octets entries;
  for (std::size_t i = 1; i < words.size(); ++i) {
    add_entries(words[i], entries);
  }
  const bus::Layout& layout = bus::TableLoadCommand::layout();
  const std::size_t count = entries.size() / bus::TableLoadEntry::layout().octets;
  if (count < 1 || count > bus::kTableLoadEntriesMax) {
    throw UnusableInput(fmt::format(
        "command table_load: {} values, allowed are 1 .. {}", count, bus::kTableLoadEntriesMax));
  }
  Octets octets(layout.octets - bus::kCrcOctets);
  bus::put_unsigned(octets, bus::table_load_layout::kEntries, count, 2);
  octets.insert(octets.end(), entries.begin(), entries.end());
  octets.resize(octets.size() + bus::kCrcOctets);
  loaded_.insert(loaded_.end(), entries.begin(), entries.end());
  return octets;
}

Octets CommandWriter::table_activate() {
  const bus::Layout& layout = bus::TableActivateCommand::layout();
  Octets octets(layout.octets);
  const std::size_t entries = loaded_.size() / bus::TableLoadEntry::layout().octets;
  bus::put_unsigned(octets, bus::table_activate_layout::kCrc32, crc32_iso_hdlc(loaded_), 4);
  bus::put_unsigned(octets, bus::table_activate_layout::kEntries, entries, 4);
  loaded_.clear();
  return octets;
}

Octets CommandWriter::packet(std::string_view line) {
  const auto words = split(line, ' ');
  if (words.empty()) {
    throw UnusableInput("a command's name is missing");
  }
  if (words[0] == "hex") {
    return octets_of_hex(words.size() == 2 ? words[1] : "-");
  }
  const bus::Layout& layout = layout_of(words[0]);
  const bool loads = layout.name == "table_load";
  const bool activates = layout.name == "table_activate" && words.size() == 1;
  Octets octets = loads       ? table_load(words)
                  : activates ? table_activate()
                              : arguments(layout, words);
  seal(layout.number, octets);
  return octets;
}

}  // namespace polhode::platform
