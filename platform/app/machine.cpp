#include "app/machine.hpp"

#include <sys/resource.h>

namespace polhode::platform {
namespace {
double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}
}  // namespace

MachineUse machine_use() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return {.peak_resident_bytes = std::int64_t{usage.ru_maxrss} * 1024,  // Linux counts in KiB
          .cpu_s = seconds(usage.ru_utime) + seconds(usage.ru_stime)};
}

}  // namespace polhode::platform
