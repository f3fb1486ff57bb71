#include "os/linux/memory/heap.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <vector>

#include "base/rng.hpp"

namespace polhode::platform::heap_test {
namespace {

constexpr std::size_t kMemory = std::size_t{1} << 20;

class HeapTest : public ::testing::Test {
 protected:
  HeapTest() { heap_.open({memory_.get(), kMemory}); }

  struct Free {
    void operator()(std::byte* p) const { ::operator delete (p, std::align_val_t{64}); }
  };
  std::unique_ptr<std::byte, Free> memory_{
      static_cast<std::byte*>(::operator new (kMemory, std::align_val_t{64}))};
  Heap heap_{};
};

TEST_F(HeapTest, HandsOutWhatWasAskedFor_Aligned_AndApart) {
  std::vector<std::pair<std::byte*, std::size_t>> blocks;
  for (std::size_t bytes : {0U, 1U, 15U, 16U, 17U, 511U, 512U, 513U, 4000U, 65537U}) {
    for (std::size_t alignment : {16U, 32U, 64U, 4096U}) {
      auto* p = static_cast<std::byte*>(heap_.allocate(bytes, alignment));
      ASSERT_NE(p, nullptr) << bytes;
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(p) % alignment, 0U);
      EXPECT_TRUE(heap_.contains(p));
      EXPECT_GE(Heap::usable_bytes(p), bytes);
      std::memset(p, 0x5A, Heap::usable_bytes(p));
      blocks.emplace_back(p, Heap::usable_bytes(p));
      ASSERT_TRUE(heap_.consistent());
    }
  }
  std::sort(blocks.begin(), blocks.end());
  for (std::size_t i = 1; i < blocks.size(); ++i) {
    EXPECT_LE(blocks[i - 1].first + blocks[i - 1].second, blocks[i].first);
  }
}

TEST_F(HeapTest, IsWholeAgain_WhenAllIsReleased) {
  const HeapUse before = heap_.use();
  std::vector<void*> blocks;
  for (std::size_t i = 0; i < 500; ++i) {
    blocks.push_back(heap_.allocate(1 + 7 * i % 900));
  }
  for (std::size_t i = 0; i < blocks.size(); i += 2) {
    heap_.release(blocks[i]);
  }
  ASSERT_TRUE(heap_.consistent());
  for (std::size_t i = 1; i < blocks.size(); i += 2) {
    heap_.release(blocks[i]);
  }
  ASSERT_TRUE(heap_.consistent());
  const HeapUse after = heap_.use();
  EXPECT_EQ(after.used_bytes, 0U);
  EXPECT_EQ(after.live_blocks, 0U);
  EXPECT_EQ(after.largest_free_bytes, before.largest_free_bytes);
  EXPECT_GT(after.peak_bytes, 100'000U);
}

TEST_F(HeapTest, SaysNo_WhenNothingIsLargeEnough_AndStaysGood) {
  EXPECT_EQ(heap_.allocate(kMemory), nullptr);
  EXPECT_EQ(heap_.allocate(~std::size_t{0}), nullptr);
  EXPECT_EQ(heap_.allocate(~std::size_t{0} - 100, 64), nullptr);
  std::vector<void*> blocks;
  while (void* p = heap_.allocate(1000)) {
    blocks.push_back(p);
  }
  // 1000 bytes and a header of 16, rounded up by at most 3 %.
  EXPECT_GE(blocks.size(), kMemory / 1056);
  EXPECT_EQ(heap_.allocate(1000), nullptr);
  ASSERT_TRUE(heap_.consistent());
  for (void* p : blocks) {
    heap_.release(p);
  }
  EXPECT_NE(heap_.allocate(kMemory / 2), nullptr);
}

TEST_F(HeapTest, GrowsInPlace_WhereThereIsRoomBehind) {
  void* p = heap_.allocate(100);
  EXPECT_TRUE(heap_.resize(p, 5000));
  EXPECT_GE(Heap::usable_bytes(p), 5000U);
  void* behind = heap_.allocate(100);
  EXPECT_FALSE(heap_.resize(p, 500'000));
  EXPECT_TRUE(heap_.resize(p, 50));
  EXPECT_LT(Heap::usable_bytes(p), 5000U);
  ASSERT_TRUE(heap_.consistent());
  heap_.release(behind);
  heap_.release(p);
  EXPECT_EQ(heap_.use().used_bytes, 0U);
}

TEST_F(HeapTest, LargestFreePromisesWhatItCanGive) {
  std::vector<void*> blocks;
  Rng rng(3, 71);
  for (int i = 0; i < 300; ++i) {
    blocks.push_back(heap_.allocate(rng.below(4000)));
  }
  for (std::size_t i = 0; i < blocks.size(); i += 3) {
    heap_.release(blocks[i]);
  }
  const std::size_t largest = heap_.use().largest_free_bytes;
  EXPECT_GT(largest, 0U);
  EXPECT_NE(heap_.allocate(largest), nullptr);
}

struct Held {
  std::byte* p;
  std::size_t bytes;
  std::uint8_t mark;
};

/// What was written is still there: nobody else was given the same memory.
bool intact(const Held& held) {
  return std::all_of(
      held.p, held.p + held.bytes, [&](std::byte b) { return b == std::byte{held.mark}; });
}

TEST_F(HeapTest, KeepsItsPromises_OverRandomUse) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Rng rng(seed, 72);
    std::vector<Held> held;
    for (int i = 0; i < 2000; ++i) {
      const std::uint32_t action = rng.below(10);
      if (action < 5 || held.empty()) {
        const std::size_t bytes = rng.below(rng.below(4) == 0 ? 30000 : 600);
        const std::size_t alignment = std::size_t{16} << rng.below(5);
        auto* p = static_cast<std::byte*>(heap_.allocate(bytes, alignment));
        if (p != nullptr) {
          held.push_back({p, bytes, static_cast<std::uint8_t>(rng.below(256))});
          std::fill(p, p + bytes, std::byte{held.back().mark});
        }
        continue;
      }
      const std::size_t which = rng.below(static_cast<std::uint32_t>(held.size()));
      Held& chosen = held[which];
      ASSERT_TRUE(intact(chosen)) << "seed " << seed;
      const std::size_t bytes = rng.below(30000);
      if (action < 7 && heap_.resize(chosen.p, bytes)) {
        chosen.bytes = bytes;
        std::fill(chosen.p, chosen.p + bytes, std::byte{chosen.mark});
      } else if (action >= 7) {
        heap_.release(chosen.p);
        held.erase(held.begin() + static_cast<std::ptrdiff_t>(which));
      }
    }
    ASSERT_TRUE(heap_.consistent()) << "seed " << seed;
    for (const Held& h : held) {
      ASSERT_TRUE(intact(h)) << "seed " << seed;
      heap_.release(h.p);
    }
    ASSERT_EQ(heap_.use().used_bytes, 0U) << "seed " << seed;
  }
}

TEST_F(HeapTest, AReleaseTwiceEndsTheProgram) {
  void* p = heap_.allocate(100);
  (void)heap_.allocate(100);
  heap_.release(p);
  EXPECT_DEATH(heap_.release(p), "");
}

}  // namespace
}  // namespace polhode::platform::heap_test
