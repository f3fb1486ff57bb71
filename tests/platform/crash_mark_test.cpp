// A run that crashes soon after its start, and the mark that it leaves.
#include "app/crash_mark.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <fstream>

#include "temporary_folder.hpp"

namespace polhode::platform::crash_mark_test {
namespace {

namespace fs = std::filesystem;

class CrashMarks : public testing::Test {
 protected:
  /// A run in a process of its own: so many frames, then the signal; 0: it ends in order.
  void run(std::uint32_t began_from, std::uint32_t frames, int signal) {
    const pid_t child = ::fork();
    if (child == 0) {
      {
        CrashWatch watch(checkpoint_, mark());
        watch.begins_from(began_from);
        for (std::uint32_t i = 0; i < frames; ++i) {
          watch.stepped();
        }
        if (signal != 0) {
          ::raise(signal);
        }
      }
      std::_Exit(0);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    EXPECT_EQ(WIFSIGNALED(status) ? WTERMSIG(status) : 0, signal);  // its death is the signal's
  }
  [[nodiscard]] CrashMark mark() const { return read_crash_mark(file_); }

  TemporaryFolder folder_;
  fs::path checkpoint_ = folder_.path() / "checkpoint";
  fs::path file_ = crash_mark_file(checkpoint_);
};

TEST_F(CrashMarks, EachSignalOfACrashLeavesOne_WithWhatTheRunBeganFrom) {
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
    fs::remove(file_);
    run(77, 3, signal);
    EXPECT_EQ(mark().crashes, 1U) << signal;
    EXPECT_TRUE(mark().was_tried(77)) << signal;
    EXPECT_FALSE(mark().was_tried(78)) << signal;
  }
}

// verifies: LIV-05
TEST_F(CrashMarks, CrashesInARowAreCounted_WithEachCheckpoint) {
  run(77, 3, SIGSEGV);
  run(88, 3, SIGABRT);
  run(0, 3, SIGSEGV);  // cold
  EXPECT_EQ(mark().crashes, 3U);
  EXPECT_TRUE(mark().was_tried(77) && mark().was_tried(88));
  EXPECT_FALSE(mark().was_tried(0));
}

TEST_F(CrashMarks, AnOrderlyEndOrEnoughFramesTakeItAway) {
  run(77, 3, SIGSEGV);
  run(88, 3, 0);
  EXPECT_FALSE(fs::exists(file_));
  run(77, 3, SIGSEGV);
  run(88, kFramesProven, SIGSEGV);  // a later crash is no matter of the start
  EXPECT_FALSE(fs::exists(file_));
  run(77, kFramesProven - 1, SIGSEGV);
  EXPECT_EQ(mark().crashes, 1U);
}

TEST_F(CrashMarks, AKillLeavesNone) {
  run(77, 3, SIGKILL);
  EXPECT_FALSE(fs::exists(file_));
}

TEST_F(CrashMarks, ADamagedOneIsNone) {
  run(77, 3, SIGSEGV);
  {
    std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(5);
    file.put('x');
  }
  EXPECT_EQ(mark().crashes, 0U);
  fs::remove(file_);
  fs::create_directory(file_);
  EXPECT_EQ(mark().crashes, 0U);
}

}  // namespace
}  // namespace polhode::platform::crash_mark_test
