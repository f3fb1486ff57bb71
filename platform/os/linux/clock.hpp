// The kernel's clocks.
#pragma once

#include <time.h>

#include <cstdint>

namespace polhode::platform {

/// The present time of CLOCK_MONOTONIC, CLOCK_REALTIME (UTC), or the processor time of the calling
/// thread by CLOCK_THREAD_CPUTIME_ID. All three are there on every Linux: no error.
inline std::int64_t clock_ns(clockid_t clock) {
  timespec now{};
  (void)::clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

/// A time that stays comparable after a restart of the program.
struct Moment {
  std::int64_t utc_ns = 0;
  std::int64_t since_boot_ns = 0;  ///< the machine's, in suspension, too: nobody sets this clock
};

inline Moment moment_now() {
  return {.utc_ns = clock_ns(CLOCK_REALTIME), .since_boot_ns = clock_ns(CLOCK_BOOTTIME)};
}

}  // namespace polhode::platform
