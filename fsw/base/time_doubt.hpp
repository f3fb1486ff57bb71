// Times that must rise, and what to do with one that was wrong.
#pragma once

#include <cstdint>

namespace polhode {

/// Of times that came after a later one: how many in a row, rising among themselves.
struct TimeDoubt {
  std::uint32_t in_a_row = 0;
  std::int64_t last_ns = 0;
};

/// Ten times in a row that rise among themselves are right, and the later one before them was
/// wrong: a clock that jumped, a bit that flipped. No queue of a camera or a bus holds as many, so
/// what was only delivered twice is not taken for it.
inline bool outvotes(std::int64_t time_ns, TimeDoubt* doubt) {
  constexpr std::uint32_t kInARow = 10;
  doubt->in_a_row = doubt->in_a_row > 0 && time_ns > doubt->last_ns ? doubt->in_a_row + 1 : 1;
  doubt->last_ns = time_ns;
  if (doubt->in_a_row < kInARow) {
    return false;
  }
  *doubt = {};
  return true;
}

}  // namespace polhode
