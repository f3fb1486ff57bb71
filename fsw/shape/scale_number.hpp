// The number of the unit of lengths: it rises by one at each change.
#pragma once

#include <cstdint>

namespace polhode {

/// The unit of lengths. Map units are those of one target frame T.
struct LengthsUnit {
  bool known = false;          ///< metres, by the scale below
  double metres_per_mu = 1.0;  ///< 1 while the scale is unknown
  std::uint32_t target_frame = 0;
  bool operator==(const LengthsUnit&) const = default;
};

/// The current unit and its number. Wraps at 2^32.
struct ScaleNumber {
  std::uint32_t number = 0;  ///< 0: nothing has been measured yet
  LengthsUnit unit{};
};

/// Number of lengths in this unit: the current one, or the next.
[[nodiscard]] inline std::uint32_t number_of(const LengthsUnit& unit, const ScaleNumber& last) {
  return unit == last.unit ? last.number : last.number + 1;
}

/// Makes this unit the current one.
inline void change_unit(const LengthsUnit& unit, ScaleNumber* scale) {
  *scale = {.number = number_of(unit, *scale), .unit = unit};
}

}  // namespace polhode
