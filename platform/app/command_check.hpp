// What a component would refuse, found before it is sent.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace polhode::platform {

/// @param text  the command as it was written, for the words of a refusal.
/// @throws UnusableInput: an argument, or a value of a table_load, is out of its range.
void check_ranges(std::span<const std::uint8_t> command, int apid_first, std::string_view text);

}  // namespace polhode::platform
