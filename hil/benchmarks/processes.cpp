#include "processes.hpp"

#include <sys/wait.h>

#include <algorithm>

namespace polhode::benchmarks {
namespace {

/// Arithmetic on more memory than a cache holds.
[[noreturn]] void want_a_core() {
  std::vector<std::uint64_t> values(4'000'000, 1);
  for (std::uint64_t turn = 1;; ++turn) {
    for (std::size_t i = 1; i < values.size(); ++i) {
      values[i] = values[i] * 6364136223846793005U + values[i - 1] + turn;
    }
  }
}

}  // namespace

double percentile_us(std::vector<std::uint32_t> values_ns, double part) {
  if (values_ns.empty()) {
    return 0.0;
  }
  std::sort(values_ns.begin(), values_ns.end());
  return 1e-3 *
         values_ns[static_cast<std::size_t>(part * static_cast<double>(values_ns.size() - 1))];
}

bool set_priority(int priority) {
  sched_param requested{};
  requested.sched_priority = priority;
  return ::sched_setscheduler(0, priority > 0 ? SCHED_FIFO : SCHED_OTHER, &requested) == 0;
}

bool set_core(int core) {
  cpu_set_t requested;
  CPU_ZERO(&requested);
  for (int i = 0; i < CPU_SETSIZE; ++i) {
    if (core < 0 || i == core) {
      CPU_SET(static_cast<unsigned>(i), &requested);
    }
  }
  return ::sched_setaffinity(0, sizeof requested, &requested) == 0;
}

void end_process(pid_t process) {
  ::kill(process, SIGKILL);
  ::waitpid(process, nullptr, 0);
}

Load::Load(int programs) {
  for (int i = 0; i < programs; ++i) {
    // Under chrt it would keep everything else off the cores, the benchmark included: hence the
    // ordinary priority.
    programs_.push_back(start_process(0, [] { want_a_core(); }));
  }
}

Load::~Load() {
  for (const pid_t program : programs_) {
    end_process(program);
  }
}

}  // namespace polhode::benchmarks
