// Processes beside a benchmark: readers, and programs that want its cores.
#pragma once

#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <new>
#include <vector>

namespace polhode::benchmarks {

/// Of values in nanoseconds; 0 without any. @param part 0 .. 1
double percentile_us(std::vector<std::uint32_t> values_ns, double part);

/// Of this process and of those that it starts from now on. @param priority 0: an ordinary one.
/// @return false when the machine does not grant it.
bool set_priority(int priority);

/// The same of the one core that they then run on. @param core -1: any
/// @return false when the machine does not grant it.
bool set_core(int core);

/// Zero at first, seen by this process and by those that it starts from now on.
template <typename T>
T* make_shared_memory() {
  void* memory =
      ::mmap(nullptr, sizeof(T), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  return new (memory) T{};
}

/// A process that does `work()` and ends, with this one at the latest. @param priority 0: an
/// ordinary one; else its memory is locked.
template <typename Work>
pid_t start_process(int priority, Work work) {
  const pid_t process = ::fork();
  if (process == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    (void)set_priority(priority);
    if (priority > 0) {
      (void)::mlockall(MCL_CURRENT | MCL_FUTURE);
    }
    work();
    std::_Exit(0);
  }
  return process;
}

/// Ends it, stopped or not.
void end_process(pid_t process);

/// Programs that want a core each at ordinary priority, as the rest of a busy computer does. They
/// end with this one.
class Load {
 public:
  explicit Load(int programs);
  ~Load();
  Load(const Load&) = delete;
  Load& operator=(const Load&) = delete;

 private:
  std::vector<pid_t> programs_;
};

}  // namespace polhode::benchmarks
