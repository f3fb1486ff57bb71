// The known name nearest to a mistyped one.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace polhode::platform {

/// @return number of single-character insertions, removals and replacements between two words.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// @return the nearest known parameter key, or nothing when none is near enough to be meant.
std::string_view nearest_parameter(std::string_view key);

}  // namespace polhode::platform
