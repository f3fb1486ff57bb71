// A program whose malloc is the fixed memory's: what every allocation of the process, the
// libraries' too, then obeys.
#include "os/linux/memory/region.hpp"

#include <gtest/gtest.h>
#include <malloc.h>
#include <pthread.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <opencv2/core/mat.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <thread>
#include <vector>

namespace polhode::platform::region_test {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;
constexpr PoolBytes kPools{16 * kMiB, 8 * kMiB, 4 * kMiB, 8 * kMiB};

// Called through pointers that the compiler cannot see through: else it leaves out an allocation
// that nobody uses.
void* (*volatile g_malloc)(std::size_t) = std::malloc;
void (*volatile g_free)(void*) = std::free;

class RegionTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    ASSERT_TRUE(memory_is_fixed()) << "this test must be linked with malloc_family.cpp";
    open_pools(kPools);
  }
  void TearDown() override {
    unseal_memory();
    for (std::size_t i = 0; i < kPoolCount; ++i) {
      (void)take_overdrafts(static_cast<Pool>(i));
    }
  }
};

TEST_F(RegionTest, AnAllocationComesFromTheThreadsPool_AndGoesBackToIt) {
  const std::size_t before = pool_use(Pool::kJobs).live_blocks;
  void* p = nullptr;
  {
    const PoolScope scope(Pool::kJobs);
    p = g_malloc(1000);
    EXPECT_EQ(pool_use(Pool::kJobs).live_blocks, before + 1);
  }
  g_free(p);  // outside the scope: the address decides
  EXPECT_EQ(pool_use(Pool::kJobs).live_blocks, before);
}

TEST_F(RegionTest, ScopesNest_AndBelongToOneThread) {
  const PoolScope step(Pool::kStep);
  const std::size_t before = pool_use(Pool::kStep).live_blocks;
  {
    const PoolScope jobs(Pool::kJobs);
    g_free(g_malloc(10));
  }
  void* p = g_malloc(10);
  EXPECT_EQ(pool_use(Pool::kStep).live_blocks, before + 1);
  std::size_t others = 0;
  std::thread([&] {
    void* q = g_malloc(10);
    others = pool_use(Pool::kStep).live_blocks;
    g_free(q);
  }).join();
  EXPECT_LE(others, before + 3) << "a thread's own book-keeping comes from its maker's pool";
  g_free(p);
}

TEST_F(RegionTest, TheWholeFamilyIsServed) {
  auto* zeros = static_cast<unsigned char*>(std::calloc(1000, 3));
  for (int i = 0; i < 3000; ++i) {
    ASSERT_EQ(zeros[i], 0);
  }
  std::memset(zeros, 7, 3000);
  zeros = static_cast<unsigned char*>(std::realloc(zeros, 100'000));
  ASSERT_NE(zeros, nullptr);
  EXPECT_EQ(zeros[2999], 7);
  EXPECT_GE(malloc_usable_size(zeros), 100'000U);
  g_free(zeros);
  void* aligned = std::aligned_alloc(256, 1000);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(aligned) % 256, 0U);
  g_free(aligned);
  void* page = nullptr;
  EXPECT_EQ(::posix_memalign(&page, 4096, 10), 0);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(page) % 4096, 0U);
  g_free(page);
  EXPECT_EQ(::posix_memalign(&page, 3, 10), EINVAL);
  volatile std::size_t huge = SIZE_MAX / 2;
  EXPECT_EQ(std::calloc(huge, 3), nullptr);
  g_free(nullptr);
}

TEST_F(RegionTest, TheVisionLibraryDrawsFromTheScope) {
  const PoolScope scope(Pool::kStep);
  const std::size_t before = pool_use(Pool::kStep).used_bytes;
  cv::Mat image(480, 640, CV_8U, cv::Scalar(3));
  EXPECT_GE(pool_use(Pool::kStep).used_bytes, before + 640 * 480);
  cv::Mat blurred;
  cv::GaussianBlur(image, blurred, {7, 7}, 0.0);
  image.release();
  blurred.release();
  EXPECT_LT(pool_use(Pool::kStep).used_bytes, before + 640 * 480);
}

TEST_F(RegionTest, BeforeTheSealAPoolThatIsFullGrowsElsewhere) {
  const PoolScope scope(Pool::kJobs);
  const std::size_t before = grown_bytes();
  void* p = g_malloc(6 * kMiB);
  ASSERT_NE(p, nullptr);
  EXPECT_GT(grown_bytes(), before);
  std::memset(p, 1, 6 * kMiB);
  g_free(p);
}

TEST_F(RegionTest, AfterTheSealOverflowDrawsOnTheReserve_AndIsCounted) {
  const PoolScope scope(Pool::kJobs);
  seal_memory();
  const std::size_t grown = grown_bytes();
  std::vector<void*> held;
  for (int i = 0; i < 5; ++i) {
    held.push_back(g_malloc(kMiB - 4096));
    ASSERT_NE(held.back(), nullptr);
    std::memset(held.back(), 1, kMiB - 4096);
  }
  EXPECT_EQ(grown_bytes(), grown);
  EXPECT_GE(take_overdrafts(Pool::kJobs), 1U);
  EXPECT_EQ(take_overdrafts(Pool::kJobs), 0U) << "taken is taken";
  EXPECT_EQ(take_overdrafts(Pool::kStep), 0U);
  for (void* p : held) {
    g_free(p);
  }
  EXPECT_EQ(pool_use(Pool::kReserve).used_bytes, 0U);
}

void exhaust_the_reserve() {
  const PoolScope scope(Pool::kJobs);
  seal_memory();
  for (;;) {
    volatile auto* p = static_cast<char*>(g_malloc(100'000));
    p[0] = 1;
  }
}

// verifies: RES-04
TEST_F(RegionTest, AnExhaustedReserveEndsTheProgram_WithItsOwnCode) {
  EXPECT_EXIT(exhaust_the_reserve(), ::testing::ExitedWithCode(kMemoryExhausted), "reserve too");
}

TEST_F(RegionTest, AnExhaustedReserveIsToldToTheHook) {
  EXPECT_EXIT(
      {
        set_exhaustion_hook([](Pool pool, std::size_t bytes) {
          ::_exit(pool == Pool::kJobs && bytes == 100'000 ? 42 : 43);
        });
        exhaust_the_reserve();
      },
      ::testing::ExitedWithCode(42),
      "");
}

TEST_F(RegionTest, ManyThreadsShareTheHeap) {
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([t] {
      const PoolScope scope(t % 2 == 0 ? Pool::kStep : Pool::kJobs);
      std::vector<std::string> texts;
      for (int i = 0; i < 3000; ++i) {
        texts.emplace_back(static_cast<std::size_t>(20 + i % 300), static_cast<char>('a' + t));
        if (texts.size() > 50) {
          texts.erase(texts.begin());
        }
      }
      for (const std::string& text : texts) {
        ASSERT_EQ(text.find_first_not_of(static_cast<char>('a' + t)), std::string::npos);
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
}

TEST_F(RegionTest, MemoryFromElsewhereCannotBeReleasedHere) {
  static char elsewhere[64];
  char* volatile p = elsewhere + 16;
  EXPECT_DEATH(region_release(p), "");
}

}  // namespace
}  // namespace polhode::platform::region_test
