// Signed numbers of the tables as subscripts.
#pragma once

#include <cstddef>
#include <cstdint>

namespace polhode {

/// @pre i >= 0
constexpr std::size_t index(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace polhode
