// The reserve exhausted in flight: a checkpoint is on the disk, and the exit code says why it
// ended.
#include "app/exhaustion.hpp"

#include <gtest/gtest.h>
#include <pthread.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "../pipeline/bench.hpp"
#include "os/linux/memory/region.hpp"

namespace polhode::platform::exhaustion_test {
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
  const CheckpointOnExhaustion last_words(*b.component, writer);
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

class Exhaustion : public ::testing::Test {
 protected:
  Exhaustion() {
    ::testing::FLAGS_gtest_death_test_style = "threadsafe";
    std::filesystem::remove(file_);
  }
  ~Exhaustion() override { std::filesystem::remove(file_); }
  // The tests run beside each other, and each in two processes, the second of which runs the test
  // anew up to the death that is expected: same session and name, same file.
  std::filesystem::path file_ = std::filesystem::temp_directory_path() /
                                ("polhode_exhaustion_" + std::to_string(::getsid(0)) + "_" +
                                 ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

// verifies: RES-04
TEST_F(Exhaustion, OfTheReserveLeavesACheckpointBehind_AndItsOwnExitCode) {
  EXPECT_EXIT(run_and_exhaust(file_, false),
              ::testing::ExitedWithCode(kMemoryExhausted),
              "exhausted.*pool 'step'");
  const LoadedCheckpoint loaded =
      load_checkpoint_file(file_, CheckpointIdentity{}, utc_now_ns(), 600);
  ASSERT_EQ(loaded.refusal, "");
  bench::Bench again;
  ASSERT_TRUE(restore_checkpoint(loaded.content, again.component));
  EXPECT_EQ(again.component->counters().frames_in, static_cast<std::uint32_t>(kSteps));
}

TEST_F(Exhaustion, OnAnotherThreadLeavesTheLastCheckpointAlone) {
  EXPECT_EXIT(run_and_exhaust(file_, true),
              ::testing::ExitedWithCode(kMemoryExhausted),
              "exhausted.*pool 'step'");
  EXPECT_FALSE(std::filesystem::exists(file_));
}

}  // namespace
}  // namespace polhode::platform::exhaustion_test
