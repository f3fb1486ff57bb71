#pragma once

#include <cstdint>

namespace polhode {

/// When a job is issued, and when its result is taken.
struct JobTimes {
  std::uint32_t step = 0;
  std::uint32_t delay = 0;         ///< steps
  std::uint32_t delay_of_all = 0;  ///< of work on the whole map
};

}  // namespace polhode
