// A parameter table changed entry by entry over the bus: by the CRC of its keys, with the checks of
// the configuration file and no heap.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "pipeline/parameter_table.hpp"

namespace polhode {

/// CRC-32 of a dotted key: the identifier of a parameter on the bus.
std::uint32_t key_crc(std::string_view key);

/// The row of this key, or nullptr.
const ParameterRow* find_parameter_by_crc(std::uint32_t crc);

/// True where the bus may change it: not the camera, jobs, budget, the seed and the application
/// process ids, which hold for a run; not the scale, which has commands of its own.
bool may_change_in_flight(std::string_view key);

/// Values that a row holds: 1, or 4 of a pair of points.
std::size_t value_count(const ParameterRow& row);

/// Writes one value: bits of a binary64 where the row is one, else a two's complement whole number.
/// @return false, nothing changed, when it is not finite, out of the row's range, or `index` too
/// large.
bool set_from_bits(const ParameterRow& row,
                   std::size_t index,
                   std::uint64_t bits,
                   Parameters* parameters);

/// The bits of one value, as set_from_bits() takes them.
std::uint64_t bits_of(const ParameterRow& row, std::size_t index, const Parameters& parameters);

/// CRC-32 over key CRC and value bits, big-endian, of all rows in the table's order.
std::uint32_t table_crc(const Parameters& parameters);

/// The first key whose value breaks its range or contradicts another's; empty when there is none.
/// Camera and scale are not looked at.
std::string_view first_bad_key(const Parameters& parameters);

}  // namespace polhode
