#include "app/crash_mark.hpp"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <span>
#include <vector>

#include "base/crc.hpp"
#include "camera/replay/file_bytes.hpp"

namespace polhode::platform {
namespace {

constexpr int kSignals[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

/// Read by the same machine only: as it lies in memory.
struct MarkFile {
  std::array<char, 4> magic{'P', 'L', 'C', 'M'};
  CrashMark mark;
  std::uint32_t crc32 = 0;
};
static_assert(sizeof(MarkFile) == 20, "no gaps: the checksum goes over all octets");

std::uint32_t crc_of(const MarkFile& file) {
  return crc32_iso_hdlc(
      {reinterpret_cast<const std::uint8_t*>(&file), sizeof file - sizeof file.crc32});
}

/// For the handler, which may only write what is ready.
struct Prepared {
  volatile sig_atomic_t armed = 0;
  std::array<char, 4096> path{};  // Linux takes no longer one
  MarkFile content;
  std::array<std::uint8_t, 65536> stack{};  // a crash may be a stack that has run out
};
Prepared g_prepared;

extern "C" void mark_and_end(int signal) {
  leave_crash_mark();
  ::raise(signal);  // its own handler is the system's again
}

void set_handlers(bool on) {
  const stack_t stack{.ss_sp = g_prepared.stack.data(),
                      .ss_flags = on ? 0 : SS_DISABLE,
                      .ss_size = g_prepared.stack.size()};
  ::sigaltstack(&stack, nullptr);
  struct sigaction action {};
  action.sa_handler = on ? mark_and_end : SIG_DFL;
  action.sa_flags = on ? static_cast<int>(SA_ONSTACK | SA_RESETHAND) : 0;
  sigemptyset(&action.sa_mask);
  for (const int signal : kSignals) {
    ::sigaction(signal, &action, nullptr);
  }
}

}  // namespace

bool CrashMark::was_tried(std::uint32_t checksum) const {
  const auto end = tried.begin() + std::min<std::uint32_t>(crashes, kWarmMax);
  return std::find(tried.begin(), end, checksum) != end;
}

std::filesystem::path crash_mark_file(const std::filesystem::path& checkpoint) {
  return checkpoint.string() + ".crashed";
}

CrashMark read_crash_mark(const std::filesystem::path& file) {
  std::vector<std::uint8_t> bytes;
  MarkFile read;
  if (read_file(file, bytes, sizeof read) || bytes.size() != sizeof read) {
    return {};
  }
  std::memcpy(&read, bytes.data(), sizeof read);
  const bool good = read.magic == MarkFile{}.magic && read.crc32 == crc_of(read);
  return good ? read.mark : CrashMark{};
}

CrashWatch::CrashWatch(const std::filesystem::path& checkpoint, const CrashMark& before)
    : file_(crash_mark_file(checkpoint)), before_(before) {
  const std::string name = file_.string();
  if (name.size() >= g_prepared.path.size()) {
    return;
  }
  std::copy(name.begin(), name.end(), g_prepared.path.begin());
  g_prepared.path[name.size()] = '\0';
  begins_from(0);
  g_prepared.armed = 1;
  set_handlers(true);
}

void CrashWatch::begins_from(std::uint32_t checksum) {
  MarkFile next{.mark = before_};
  if (next.mark.crashes < CrashMark::kWarmMax) {
    next.mark.tried[next.mark.crashes] = checksum;
  }
  next.mark.crashes = std::min(before_.crashes, 1000U) + 1;
  next.crc32 = crc_of(next);
  g_prepared.content = next;
}

CrashWatch::~CrashWatch() {
  if (g_prepared.armed != 0) {
    g_prepared.armed = 0;
    set_handlers(false);
    if (frames_ > 0 && std::uncaught_exceptions() == 0) {
      (void)::unlink(file_.c_str());
    }
  }
}

void CrashWatch::stepped() {
  if (++frames_ == kFramesProven && g_prepared.armed != 0) {
    g_prepared.armed = 0;
    (void)::unlink(file_.c_str());
  }
}

bool leave_crash_mark() {
  if (g_prepared.armed == 0) {
    return false;
  }
  g_prepared.armed = 0;
  const int file =
      ::open(g_prepared.path.data(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0640);
  if (file >= 0) {
    [[maybe_unused]] const auto written =
        ::write(file, &g_prepared.content, sizeof g_prepared.content);
    (void)::fsync(file);
    ::close(file);
  }
  return true;
}

}  // namespace polhode::platform
