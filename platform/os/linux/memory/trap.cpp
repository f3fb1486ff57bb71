#include "os/linux/memory/trap.hpp"

#include <errno.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace polhode::platform {
namespace {

struct Call {
  unsigned number;
  const char* name;
};

constexpr Call kCalls[] = {
    {__NR_mmap, "mmap"},
    {__NR_mremap, "mremap"},
    {__NR_munmap, "munmap"},
    {__NR_mprotect, "mprotect"},
    {__NR_brk, "brk"},
    {__NR_madvise, "madvise"},
    {__NR_clone, "clone"},
    {__NR_clone3, "clone3"},
#ifdef __NR_fork  // calls that newer architectures do without
    {__NR_fork, "fork"},
    {__NR_vfork, "vfork"},
#endif
    {__NR_openat, "openat"},  // files: the last ones
#ifdef __NR_open
    {__NR_open, "open"},
#endif
};
constexpr std::size_t kCallCount = sizeof kCalls / sizeof kCalls[0];
#ifdef __NR_open
constexpr std::size_t kFileCalls = 2;
#else
constexpr std::size_t kFileCalls = 1;
#endif

#if defined(__x86_64__)
constexpr unsigned kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr unsigned kArchitecture = AUDIT_ARCH_AARCH64;
#else
#error "the trap does not know this architecture's system calls"
#endif

void write_text(const char* text) {
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text, std::strlen(text));
}

void on_trap(int /*signal*/, siginfo_t* info, void* /*context*/) {
  write_text("trapped after the seal: ");
  for (const Call& call : kCalls) {
    if (call.number == static_cast<unsigned>(info->si_syscall)) {
      write_text(call.name);
    }
  }
  write_text("\n");
  ::_exit(kTrapped);
}

}  // namespace

bool set_memory_trap(bool files) {
  struct sigaction action {};
  action.sa_sigaction = on_trap;
  action.sa_flags = SA_SIGINFO;
  if (::sigaction(SIGSYS, &action, nullptr) != 0) {
    return false;
  }
  // Another architecture's numbers: let through. Each listed call jumps to the trap at the end.
  std::array<sock_filter, kCallCount + 5> program{};
  std::size_t i = 0;
  program[i++] = BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, arch));
  const std::size_t count = files ? kCallCount : kCallCount - kFileCalls;
  program[i++] =
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kArchitecture, 0, static_cast<std::uint8_t>(count + 1));
  program[i++] = BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr));
  for (std::size_t c = 0; c < count; ++c) {
    const auto to_trap = static_cast<std::uint8_t>(count - c);
    program[i++] = BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, kCalls[c].number, to_trap, 0);
  }
  program[i++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW);
  program[i++] = BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP);
  const sock_fprog filter{.len = static_cast<unsigned short>(i), .filter = program.data()};
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) {
    return false;
  }
  return ::syscall(__NR_seccomp, SECCOMP_SET_MODE_FILTER, SECCOMP_FILTER_FLAG_TSYNC, &filter) == 0;
}

}  // namespace polhode::platform
