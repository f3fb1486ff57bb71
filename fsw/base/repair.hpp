// What became of a table that was found damaged.
#pragma once

#include <cstdint>

namespace polhode {

struct Repair {
  std::uint32_t entries = 0;  ///< dropped, or put right
  bool reset = false;         ///< nothing of the table could be kept
  [[nodiscard]] bool any() const { return entries > 0 || reset; }
};

}  // namespace polhode
