#include "os/linux/priority.hpp"

#include <sched.h>
#include <sys/resource.h>

#include <cerrno>
#include <system_error>

namespace polhode::platform {

std::string take_priority(int priority) {
  sched_param requested{};
  requested.sched_priority = priority;
  if (::sched_setscheduler(0, SCHED_FIFO, &requested) == 0) {  // 0: of this thread alone
    return {};
  }
  const std::string reason = std::generic_category().message(errno);
  rlimit limit{};
  ::getrlimit(RLIMIT_RTPRIO, &limit);
  return "no real-time priority: " + reason + "; the limit (ulimit -r) is " +
         std::to_string(limit.rlim_cur);
}

std::string take_core(int core) {
  cpu_set_t requested;
  CPU_ZERO(&requested);
  CPU_SET(static_cast<unsigned>(core),
          &requested);  // one that a set has no room for is left out, and refused below
  if (::sched_setaffinity(0, sizeof requested, &requested) == 0) {
    return {};
  }
  return "not bound to core " + std::to_string(core) + ": " +
         std::generic_category().message(errno);
}

}  // namespace polhode::platform
