#include "bus/fields.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "base/assert.hpp"
#include "bus/octets.hpp"

namespace polhode::bus {
namespace {

constexpr char kFirstPrintable = ' ';
constexpr char kLastPrintable = '~';

const std::byte* member_of(const Field& field, const void* packet, std::size_t index) {
  POLHODE_ASSERT(index < field.count, index);
  return static_cast<const std::byte*>(packet) + field.member + index * size_of(field.type);
}
std::byte* member_of(const Field& field, void* packet, std::size_t index) {
  POLHODE_ASSERT(index < field.count, index);
  return static_cast<std::byte*>(packet) + field.member + index * size_of(field.type);
}

template <typename T>
T load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

/// The value's bits, in the low octets.
std::uint64_t bits_of(const Field& field, const std::byte* from) {
  switch (size_of(field.type)) {
    case 1:
      return load<std::uint8_t>(from);
    case 2:
      return load<std::uint16_t>(from);
    case 4:
      return load<std::uint32_t>(from);
    default:
      return load<std::uint64_t>(from);
  }
}

void set_bits(const Field& field, std::uint64_t bits, std::byte* to) {
  const auto store = [to](auto value) { std::memcpy(to, &value, sizeof value); };
  switch (size_of(field.type)) {
    case 1:
      return store(static_cast<std::uint8_t>(bits));
    case 2:
      return store(static_cast<std::uint16_t>(bits));
    case 4:
      return store(static_cast<std::uint32_t>(bits));
    default:
      return store(bits);
  }
}

bool is_valid(const Field& field, std::uint8_t flags) {
  return field.valid_by < 0 || (flags >> static_cast<unsigned>(field.valid_by) & 1U) != 0;
}

bool all_finite(const Field& field, const void* packet) {
  for (std::size_t i = 0; i < field.count; ++i) {
    if (!std::isfinite(value_of(field, packet, i))) {
      return false;
    }
  }
  return true;
}

void clear_field(const Field& field, void* packet) {
  std::fill_n(member_of(field, packet, 0), field.count * size_of(field.type), std::byte{0});
}

void sanitise_text(const Field& field, void* packet) {
  bool ended = false;
  for (std::size_t i = 0; i < field.count; ++i) {
    const auto c = load<char>(member_of(field, packet, i));
    ended = ended || c == '\0';
    const bool printable = c >= kFirstPrintable && c <= kLastPrintable;
    set_bits(field,
             ended       ? 0U
             : printable ? static_cast<unsigned char>(c)
                         : '?',
             member_of(field, packet, i));
  }
}

std::uint8_t valid_flags(const Layout& layout, const void* packet) {
  unsigned flags = flags_of(layout, packet);
  for (const Field& field : layout.fields) {
    if (field.valid_by >= 0 && !all_finite(field, packet)) {
      flags &= ~(1U << static_cast<unsigned>(field.valid_by));
    }
  }
  return static_cast<std::uint8_t>(flags);
}

}  // namespace

std::size_t size_of(FieldType type) {
  switch (type) {
    case FieldType::kU8:
    case FieldType::kText:
      return 1;
    case FieldType::kU16:
      return 2;
    case FieldType::kU32:
    case FieldType::kF32:
      return 4;
    case FieldType::kU64:
    case FieldType::kI64:
    case FieldType::kF64:
      break;
  }
  return 8;
}

const Layout* find_packet(int apid, int apid_first) {
  for (const Layout* layout : packet_layouts()) {
    if (apid - apid_first == layout->number) {
      return layout;
    }
  }
  return nullptr;
}

double value_of(const Field& field, const void* packet, std::size_t index) {
  const std::byte* from = member_of(field, packet, index);
  switch (field.type) {
    case FieldType::kF32:
      return static_cast<double>(load<float>(from));
    case FieldType::kF64:
      return load<double>(from);
    case FieldType::kI64:
      return static_cast<double>(load<std::int64_t>(from));
    default:
      return static_cast<double>(bits_of(field, from));
  }
}

std::uint8_t flags_of(const Layout& layout, const void* packet) {
  return layout.flags_member == kNoFlags
             ? std::uint8_t{0}
             : load<std::uint8_t>(static_cast<const std::byte*>(packet) + layout.flags_member);
}

void sanitise(const Layout& layout, void* packet) {
  const std::uint8_t flags = valid_flags(layout, packet);
  if (layout.flags_member != kNoFlags) {
    std::memcpy(static_cast<std::byte*>(packet) + layout.flags_member, &flags, sizeof flags);
  }
  for (const Field& field : layout.fields) {
    if (field.type == FieldType::kText) {
      sanitise_text(field, packet);
    } else if (!is_valid(field, flags) || !all_finite(field, packet)) {
      clear_field(field, packet);
    }
  }
}

void pack_fields(const Layout& layout, const void* packet, std::span<std::uint8_t> out) {
  for (const Field& field : layout.fields) {
    const std::size_t size = size_of(field.type);
    for (std::size_t i = 0; i < field.count; ++i) {
      put_unsigned(out, field.octet + i * size, bits_of(field, member_of(field, packet, i)), size);
    }
  }
}

void unpack_fields(const Layout& layout, std::span<const std::uint8_t> in, void* packet) {
  for (const Field& field : layout.fields) {
    const std::size_t size = size_of(field.type);
    for (std::size_t i = 0; i < field.count; ++i) {
      set_bits(field, get_unsigned(in, field.octet + i * size, size), member_of(field, packet, i));
    }
  }
}

const Field* out_of_range(const Layout& layout, const void* packet, double slack) {
  const std::uint8_t flags = flags_of(layout, packet);
  for (const Field& field : layout.fields) {
    if (field.type == FieldType::kText || !is_valid(field, flags)) {
      continue;
    }
    const bool floating = field.type == FieldType::kF32 || field.type == FieldType::kF64;
    const double low = field.low - (floating ? slack * std::max(1.0, std::abs(field.low)) : 0.0);
    const double high = field.high + (floating ? slack * std::max(1.0, std::abs(field.high)) : 0.0);
    for (std::size_t i = 0; i < field.count; ++i) {
      const double value = value_of(field, packet, i);
      if (!std::isfinite(value) || value < low || value > high) {
        return &field;
      }
    }
  }
  return nullptr;
}

std::string_view word_of(std::string_view words, std::size_t index) {
  for (std::size_t i = 0; i < index; ++i) {
    const std::size_t space = words.find(' ');
    if (space == std::string_view::npos) {
      return {};
    }
    words.remove_prefix(space + 1);
  }
  return words.substr(0, words.find(' '));
}

}  // namespace polhode::bus
