#include "bus/frame_uses.hpp"

#include <gtest/gtest.h>

#include <set>

#include "bus/counter_table.hpp"

namespace polhode::frame_uses_test {
namespace {

constexpr int kUses = static_cast<int>(FrameUse::kBitErrors) + 1;
constexpr int kFaults = static_cast<int>(FrameFault::kBlurred) + 1;

const char* name_of(std::uint32_t Counters::*counter) {
  for (const bus::CounterRow& row : bus::kCounters) {
    if (row.counted == counter) {
      return row.name;
    }
  }
  return nullptr;
}

TEST(FrameUses, EveryUseHasOneRowOfItsOwn) {
  for (int use = 0; use < kUses; ++use) {
    EXPECT_EQ(row_of(static_cast<FrameUse>(use)).use, static_cast<FrameUse>(use));
  }
  EXPECT_EQ(std::size(kFrameUseRows), static_cast<std::size_t>(kUses));
}

TEST(FrameUses, EveryFaultHasARow_AndNoneHasNone) {
  for (int fault = 0; fault < kFaults; ++fault) {
    const FrameFaultRow* const row = row_of(static_cast<FrameFault>(fault));
    EXPECT_EQ(row == nullptr, static_cast<FrameFault>(fault) == FrameFault::kNone) << fault;
    EXPECT_TRUE(row == nullptr || row->fault == static_cast<FrameFault>(fault));
  }
}

TEST(FrameUses, EveryCounterIsCountedOnce) {
  std::set<std::string> counted;
  for (const FrameUseRow& row : kFrameUseRows) {
    EXPECT_TRUE(row.counter == nullptr || counted.insert(name_of(row.counter)).second);
  }
  for (const FrameFaultRow& row : kFrameFaultRows) {
    EXPECT_TRUE(counted.insert(name_of(row.counter)).second);
  }
}

TEST(FrameUses, AUseWithoutACounterIsOneThatAFaultCounts) {
  for (const FrameUseRow& use : kFrameUseRows) {
    bool by_fault = false;
    for (const FrameFaultRow& fault : kFrameFaultRows) {
      by_fault = by_fault || fault.skipped == use.use;
    }
    EXPECT_TRUE(use.counter != nullptr || by_fault);
  }
}

TEST(FrameUses, WhatIsNotUsedHasAnEvent_UnlessItWasHeldByCommand) {
  for (const FrameUseRow& row : kFrameUseRows) {
    EXPECT_EQ(row.has_event, row.use != FrameUse::kUsed && row.use != FrameUse::kHeld);
  }
}

TEST(Counters, EveryOneIsPublishedUnderItsOwnName) {
  Counters counters;
  bus::HousekeepingPacket packet;
  std::uint32_t value = 0;
  for (const bus::CounterRow& row : bus::kCounters) {
    counters.*row.counted = ++value;
    packet.*row.published = counters.*row.counted;
  }
  EXPECT_EQ(sizeof(Counters), bus::kCounters.size() * sizeof(std::uint32_t));
  EXPECT_EQ(packet.frames_in, 1U);
  EXPECT_EQ(packet.tables_full, value);
}

}  // namespace
}  // namespace polhode::frame_uses_test
