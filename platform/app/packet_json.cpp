#include "app/packet_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "quote.hpp"

namespace polhode::platform {
namespace {

using Json = nlohmann::ordered_json;

bool is_up(const bus::Layout& layout, const void* packet, int bit) {
  return bit < 0 || (bus::flags_of(layout, packet) >> static_cast<unsigned>(bit) & 1U) != 0;
}

unsigned number_in_flags(const bus::Layout& layout, const void* packet) {
  return static_cast<unsigned>(bus::flags_of(layout, packet)) >> 4U;
}

bool is_flags(const bus::Field& field) { return field.name == "flags"; }
bool is_spare(const bus::Field& field) { return field.name == "spare"; }

/// Whole numbers of 64 bits do not fit a double.
Json whole_number(const bus::Field& field, const void* packet, std::size_t index) {
  if (bus::size_of(field.type) < 8) {
    return static_cast<std::uint64_t>(bus::value_of(field, packet, index));
  }
  std::int64_t value = 0;
  std::memcpy(
      &value, static_cast<const std::byte*>(packet) + field.member + 8 * index, sizeof value);
  return field.type == bus::FieldType::kU64 ? Json(static_cast<std::uint64_t>(value)) : Json(value);
}

Json value_json(const bus::Field& field, const void* packet, std::size_t index) {
  if (!field.enumeration.empty()) {
    const auto value = static_cast<std::size_t>(bus::value_of(field, packet, index));
    return std::string(bus::word_of(field.enumeration, value));
  }
  const bool real = field.type == bus::FieldType::kF32 || field.type == bus::FieldType::kF64;
  return real ? Json(bus::value_of(field, packet, index)) : whole_number(field, packet, index);
}

/// Of a code; its number where it has no name.
std::string code_name(const bus::Field& field, const void* packet) {
  const double code = bus::value_of(field, packet, 0);
  const std::string_view name = bus::name_of(field.names, code);
  return name.empty() ? fmt::format("{:.0f}", code) : std::string(name);
}

std::string text_of(const bus::Field& field, const void* packet) {
  std::string text;
  for (std::size_t i = 0; i < field.count; ++i) {
    const auto c = static_cast<char>(bus::value_of(field, packet, i));
    if (c == '\0') {
      break;
    }
    text += c;
  }
  return text;
}

Json field_json(const bus::Field& field, const void* packet) {
  if (field.type == bus::FieldType::kText) {
    return text_of(field, packet);
  }
  if (!field.is_array) {
    return value_json(field, packet, 0);
  }
  Json values = Json::array();
  for (std::size_t i = 0; i < field.count; ++i) {
    values.push_back(value_json(field, packet, i));
  }
  return values;
}

std::string value_text(const bus::Field& field, const void* packet) {
  constexpr std::size_t kValuesShown = 8;
  const bool real = field.type == bus::FieldType::kF32 || field.type == bus::FieldType::kF64;
  if (field.type == bus::FieldType::kText) {
    return fmt::format("\"{}\"", cited(text_of(field, packet)));
  }
  if (!field.names.empty()) {
    return code_name(field, packet);
  }
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(field.count, kValuesShown); ++i) {
    text += i == 0 ? "" : " ";
    if (real) {
      text += fmt::format("{:.6g}", bus::value_of(field, packet, i));
    } else {
      const Json value = value_json(field, packet, i);
      text += value.is_string() ? value.get<std::string>() : value.dump();
    }
  }
  return field.count > kValuesShown ? text + " ..." : text;
}

bool guards_fields(const bus::Layout& layout, std::size_t bit) {
  for (const bus::Field& field : layout.fields) {
    if (field.valid_by == static_cast<int>(bit)) {
      return true;
    }
  }
  return false;
}

}  // namespace

std::string flag_key(const bus::Layout& layout, std::size_t bit) {
  const std::string name(bus::word_of(layout.flag_names, bit));
  const bool validity = guards_fields(layout, bit) && name != "scale_known";
  return validity ? name + "_valid" : name;
}

Json fields_json(const bus::Layout& layout, const void* packet) {
  Json out;
  for (const bus::Field& field : layout.fields) {
    if (is_flags(field)) {
      for (std::size_t bit = 0; !bus::word_of(layout.flag_names, bit).empty(); ++bit) {
        out[flag_key(layout, bit)] = is_up(layout, packet, static_cast<int>(bit));
      }
      if (!layout.number_name.empty()) {
        out[std::string(layout.number_name)] = number_in_flags(layout, packet);
      }
    } else if (!is_spare(field)) {
      const bool valid = is_up(layout, packet, field.valid_by);
      out[std::string(field.name)] = valid ? field_json(field, packet) : Json();
      if (!field.names.empty()) {
        out[fmt::format("{}_name", field.name)] = code_name(field, packet);
      }
    }
  }
  return out;
}

std::string fields_text(const bus::Layout& layout, const void* packet) {
  std::string line;
  for (const bus::Field& field : layout.fields) {
    if (is_spare(field) || field.name == "timestamp_ns" || field.name.starts_with("cov_")) {
      continue;
    }
    if (is_flags(field)) {
      for (std::size_t bit = 0; !bus::word_of(layout.flag_names, bit).empty(); ++bit) {
        line += is_up(layout, packet, static_cast<int>(bit))
                    ? fmt::format(" +{}", bus::word_of(layout.flag_names, bit))
                    : "";
      }
      line += layout.number_name.empty()
                  ? ""
                  : fmt::format(" {}={}", layout.number_name, number_in_flags(layout, packet));
    } else if (is_up(layout, packet, field.valid_by)) {
      line += fmt::format(" {}={}", field.name, value_text(field, packet));
    }
  }
  return line.empty() ? line : line.substr(1);
}

}  // namespace polhode::platform
