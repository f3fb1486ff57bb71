// Result of the repair of a damaged table.
#pragma once

#include <cstdint>

namespace polhode {

struct Repair {
  std::uint32_t entries = 0;  ///< dropped or repaired
  bool reset = false;         ///< nothing of the table could be kept
  [[nodiscard]] bool any() const { return entries > 0 || reset; }
};

}  // namespace polhode
