#pragma once

#include <cstdint>

namespace polhode {

/// When a job is issued, and when its result is taken.
struct JobTimes {
  std::uint32_t step = 0;
  std::uint32_t delay = 0;            ///< steps
  std::uint32_t delay_of_window = 0;  ///< of an adjustment of a window of the map
  std::uint32_t delay_of_all = 0;     ///< at most, of an adjustment of the whole map
};

}  // namespace polhode
