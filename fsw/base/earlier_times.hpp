// Time stamps that must rise, and which of two contradicting ones was wrong.
#pragma once

#include <cstdint>

namespace polhode {

/// Time stamps not later than the accepted one: how many in a row, rising among themselves.
struct EarlierTimes {
  std::uint32_t in_a_row = 0;
  std::int64_t last_ns = 0;
};

/// Ten time stamps in a row that rise among themselves are right. The later one before them was
/// wrong: a clock jumped or a bit flipped.
inline bool outvotes(std::int64_t time_ns, EarlierTimes* times) {
  // No queue of a camera or a bus holds as many: frames delivered twice do not reach it.
  constexpr std::uint32_t kInARow = 10;
  times->in_a_row = times->in_a_row > 0 && time_ns > times->last_ns ? times->in_a_row + 1 : 1;
  times->last_ns = time_ns;
  if (times->in_a_row < kInARow) {
    return false;
  }
  *times = {};
  return true;
}

}  // namespace polhode
