// A run that ends by a fault of its own: a checkpoint is on the disk, and the end states its
// reason.
#include "app/failure.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "../pipeline/bench.hpp"
#include "app/crash_mark.hpp"
#include "base/assert.hpp"
#include "os/linux/memory/region.hpp"

namespace polhode::platform::failure_test {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;
constexpr int kSteps = 7;

void* (*volatile g_malloc)(std::size_t) = std::malloc;

/// What a library does that asks for more and more within a step.
void exhaust_the_reserve() {
  const PoolScope scope(Pool::kStep);
  for (;;) {
    (void)g_malloc(kMiB / 4);
  }
}

/// A run that has made some steps, and then has no memory left.
[[noreturn]] void run_and_exhaust(const std::filesystem::path& file, bool on_another_thread) {
  open_pools({96 * kMiB, 8 * kMiB, 4 * kMiB, 8 * kMiB});
  bench::Bench b;
  CheckpointWriter writer(file, CheckpointIdentity{});
  const CheckpointOnFailure last_words(*b.component, writer);
  for (int i = 0; i < kSteps; ++i) {
    (void)b.show(bench::uniform(0));
  }
  const auto other = [](void*) -> void* {
    exhaust_the_reserve();
    return nullptr;
  };
  seal_memory();
  if (on_another_thread) {
    pthread_t thread{};
    pthread_create(&thread, nullptr, other, nullptr);
    pthread_join(thread, nullptr);
  }
  exhaust_the_reserve();
  std::abort();
}

/// A run of so many steps whose component finds a mistake of ours in the next one.
[[noreturn]] void run_and_assert(const std::filesystem::path& file,
                                 bool on_another_thread,
                                 int steps) {
  bench::Bench b;
  CrashWatch watch(file, CrashMark{});
  CheckpointWriter writer(file, CheckpointIdentity{});
  const CheckpointOnFailure last_words(*b.component, writer);
  for (int i = 0; i < steps; ++i) {
    (void)b.show(bench::uniform(0));
    watch.stepped();
  }
  const auto fail = [](void*) -> void* { assertion_failed("a < b", "room/file.cpp", 7, 2.5); };
  if (on_another_thread) {
    pthread_t thread{};
    pthread_create(&thread, nullptr, fail, nullptr);
    pthread_join(thread, nullptr);
  }
  fail(nullptr);
  std::abort();
}

class Failure : public ::testing::Test {
 protected:
  Failure() {
    ::testing::FLAGS_gtest_death_test_style = "threadsafe";
    remove_files();
  }
  ~Failure() override { remove_files(); }
  void remove_files() const {
    std::filesystem::remove(file_);
    std::filesystem::remove(crash_mark_file(file_));
  }
  // The tests run beside each other, and each in two processes, the second of which runs the test
  // again up to the death that is expected: same session and name, same file.
  std::filesystem::path file_ = std::filesystem::temp_directory_path() /
                                ("polhode_failure_" + std::to_string(::getsid(0)) + "_" +
                                 ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

// verifies: RES-04
TEST_F(Failure, OfMemoryLeavesACheckpointBehind_AndItsOwnExitCode) {
  EXPECT_EXIT(run_and_exhaust(file_, false),
              ::testing::ExitedWithCode(kMemoryExhausted),
              "exhausted.*pool 'step'");
  const LoadedCheckpoint loaded =
      load_checkpoint_file(file_, CheckpointIdentity{}, moment_now(), 600);
  ASSERT_EQ(loaded.refusal, "");
  bench::Bench again;
  ASSERT_TRUE(restore_checkpoint(loaded.content, again.component));
  EXPECT_EQ(again.component->counters().frames_in, static_cast<std::uint32_t>(kSteps));
}

TEST_F(Failure, OfMemoryOnAnotherThreadLeavesTheLastCheckpointAlone) {
  EXPECT_EXIT(run_and_exhaust(file_, true),
              ::testing::ExitedWithCode(kMemoryExhausted),
              "exhausted.*pool 'step'");
  EXPECT_FALSE(std::filesystem::exists(file_));
}

constexpr const char* kTold = "room/file.cpp:7: assertion failed: a < b \\(2.5\\)";

TEST_F(Failure, OfAnAssertionLeavesACheckpointBehind_AndSaysWhere) {
  const int steps = static_cast<int>(kFramesProven) + 3;
  EXPECT_EXIT(run_and_assert(file_, false, steps), ::testing::KilledBySignal(SIGABRT), kTold);
  EXPECT_FALSE(std::filesystem::exists(crash_mark_file(file_))) << "the start had held";
  const LoadedCheckpoint loaded =
      load_checkpoint_file(file_, CheckpointIdentity{}, moment_now(), 600);
  ASSERT_EQ(loaded.refusal, "");
  bench::Bench again;
  ASSERT_TRUE(restore_checkpoint(loaded.content, again.component));
  EXPECT_EQ(again.component->counters().frames_in, static_cast<std::uint32_t>(steps));
}

TEST_F(Failure, OfAnAssertionSoonAfterTheStartLeavesAMark_AndNoStateThatMayHaveLedToIt) {
  EXPECT_EXIT(run_and_assert(file_, false, kSteps), ::testing::KilledBySignal(SIGABRT), kTold);
  EXPECT_FALSE(std::filesystem::exists(file_));
  EXPECT_EQ(read_crash_mark(crash_mark_file(file_)).crashes, 1U);
}

TEST_F(Failure, OfAnAssertionOnAnotherThreadLeavesTheLastCheckpointAlone) {
  const int steps = static_cast<int>(kFramesProven) + 3;
  EXPECT_EXIT(run_and_assert(file_, true, steps), ::testing::KilledBySignal(SIGABRT), kTold);
  EXPECT_FALSE(std::filesystem::exists(file_));
}

}  // namespace
}  // namespace polhode::platform::failure_test
