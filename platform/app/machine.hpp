// Resources that this process has taken from the machine so far.
#pragma once

#include <cstdint>

namespace polhode::platform {

struct MachineUse {
  std::int64_t peak_resident_bytes = 0;
  double cpu_s = 0.0;  ///< user and system time of all threads
};

MachineUse machine_use();

}  // namespace polhode::platform
