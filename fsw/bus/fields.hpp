// The fields of a packet on the wire and in its struct, as data. So one piece of code packs,
// unpacks, validates and prints all packets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "bus/code_names.hpp"

namespace polhode::bus {

enum class FieldType : std::uint8_t { kU8, kU16, kU32, kU64, kI64, kF32, kF64, kText };

inline constexpr double kNoLimit = std::numeric_limits<double>::infinity();
inline constexpr std::size_t kNoFlags = std::numeric_limits<std::size_t>::max();
// Of any packet's or command's struct: limits::kPacketOctets and padding, rounded up to a power of
// two. packet_table.cpp asserts it for each.
inline constexpr std::size_t kStructOctetsMax = 2048;

/// A field, by its row in the field table.
struct Field {
  std::string_view name;
  FieldType type;
  std::uint16_t count;  ///< values; of a text: octets
  bool is_array;
  std::uint16_t octet;   ///< from the packet's first
  std::size_t member;    ///< offset in the struct
  std::int8_t valid_by;  ///< bit of the flags that must be up; -1: always valid
  double low;            ///< allowed, both included
  double high;
  std::string_view elements;        ///< names of an array's elements, "w x y z"; may be empty
  std::string_view unit;            ///< may be empty
  std::string_view enumeration;     ///< names of the values 0, 1, ...; may be empty
  std::span<const CodeName> names;  ///< where the value is a code with a name for people
};

struct Layout {
  std::string_view name;
  std::uint8_t number;   ///< APID above the first one, or function code
  std::uint16_t octets;  ///< with the CRC; a command's entries not counted
  std::span<const Field> fields;
  std::size_t flags_member;     ///< offset of the flags in the struct, or kNoFlags
  std::string_view flag_names;  ///< "pose rate", bit 0 first
  std::string_view
      number_name;  ///< of a number in the flags' upper four bits; empty: there is none
};

/// All telemetry packets, and all commands by their codes.
std::span<const Layout* const> packet_layouts();
std::span<const Layout* const> command_layouts();

/// The layout of this APID, or nullptr.
const Layout* find_packet(int apid, int apid_first);

/// Octets of one value: 1, 2, 4 or 8.
[[nodiscard]] std::size_t size_of(FieldType type);

/// Makes a packet's struct valid for the bus. A flag whose values are not all finite goes down.
/// Values whose flag is down, and others that are not finite, become zero. Texts are reduced to
/// printable ASCII.
void sanitise(const Layout& layout, void* packet);

/// Writes the fields (not header and CRC) big-endian. What is written must be sanitised.
void pack_fields(const Layout& layout, const void* packet, std::span<std::uint8_t> out);

/// Reads the fields back. `in` holds at least up to the last one.
void unpack_fields(const Layout& layout, std::span<const std::uint8_t> in, void* packet);

/// The first field that is out of range or not finite, or nullptr. Values whose flag is down are
/// not checked.
/// @param slack  by which a floating value may exceed a limit, relative to limits over 1. A unit
/// vector's component may exceed 1 by a rounding error.
const Field* out_of_range(const Layout& layout, const void* packet, double slack);

/// One value as a number (of a text: its octet). Whole numbers over 2^53 lose their last digits.
[[nodiscard]] double value_of(const Field& field, const void* packet, std::size_t index);

/// The flags of a packet; 0 where it has none.
[[nodiscard]] std::uint8_t flags_of(const Layout& layout, const void* packet);

/// Word number `index` of "a b c"; empty when there are fewer.
[[nodiscard]] std::string_view word_of(std::string_view words, std::size_t index);

}  // namespace polhode::bus
