#include "app/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "app/motion_csv.hpp"
#include "print_stderr.hpp"

namespace polhode::platform {
namespace {
using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kTerminalPeriod{200};
constexpr std::chrono::seconds kLogPeriod{5};
}  // namespace

Progress::Progress(std::size_t frames)
    : frames_(frames),
      terminal_(::isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      last_(start_) {}

Progress::~Progress() { wipe(); }

void Progress::wipe() {
  if (drawn_) {
    std::fputs("\r\033[K", stderr);
    drawn_ = false;
  }
}

void Progress::update(std::size_t frames_done, const MotionState& motion) {
  const Clock::time_point now = Clock::now();
  if (now - last_ < (terminal_ ? Clock::duration(kTerminalPeriod) : Clock::duration(kLogPeriod))) {
    return;
  }
  last_ = now;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  const std::string line =
      fmt::format("frame {}/{}  {}  {} landmarks  {} keyframes  {:.1f} frames/s",
                  frames_done,
                  frames_,
                  mode_name(motion.mode),
                  motion.landmarks,
                  motion.keyframes,
                  static_cast<double>(frames_done) / seconds);
  wipe();
  std::fputs(line.c_str(), stderr);
  drawn_ = terminal_;
  if (!terminal_) {
    std::fputc('\n', stderr);
  }
}

void Progress::note(const std::string& line) {
  wipe();
  print_stderr("{}\n", line);
}

}  // namespace polhode::platform
