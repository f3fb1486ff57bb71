#include "os/linux/memory/lock.hpp"

#include <errno.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cstring>

namespace polhode::platform {

std::string lock_memory() {
  if (::mlockall(MCL_CURRENT | MCL_ONFAULT) == 0) {
    return {};
  }
  const int problem = errno;
  rlimit limit{};
  ::getrlimit(RLIMIT_MEMLOCK, &limit);
  return std::string("memory is not locked: ") + std::strerror(problem) +
         "; the limit on locked memory (ulimit -l) is " + std::to_string(limit.rlim_cur / 1024) +
         " KiB";
}

}  // namespace polhode::platform
