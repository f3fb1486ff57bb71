// Finds refusals of a command before it is sent.
#pragma once

#include <cstdint>
#include <span>

namespace polhode::platform {

/// @throws UnusableInput naming the argument, or the parameter of a table_load, its value and what
/// is allowed.
void check_ranges(std::span<const std::uint8_t> command, int apid_first);

}  // namespace polhode::platform
