#include "bus/frame_uses.hpp"

#include <gtest/gtest.h>

#include <set>

#include "bus/counter_table.hpp"
#include "bus/events.hpp"
#include "bus/report_changes.hpp"

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
    bus::EventLog log;
    bus::report_frame(7, row.use, {.measure = 0.5F}, &log);
    const bool silent = row.use == FrameUse::kUsed || row.use == FrameUse::kHeld;
    ASSERT_EQ(log.waiting.size(), silent ? 0U : 1U);
    // What an image was assessed by goes along; the others were not looked at.
    const bool measured = row.counter == nullptr;
    for (const bus::EventPacket& packet : log.waiting) {
      EXPECT_EQ(packet.value, (std::array<double, 2>{7.0, measured ? 0.5 : 0.0}));
    }
  }
}

TEST(FrameUses, ADegradedFrameHasAnEventWithItsFault) {
  bus::EventLog log;
  bus::report_frame(
      7, FrameUse::kUsed, {.decision = FrameDecision::kCare, .fault = FrameFault::kBlurred}, &log);
  ASSERT_EQ(log.waiting.size(), 1U);
  EXPECT_EQ(log.waiting[0].id, static_cast<std::uint16_t>(bus::EventId::kFrameWithCare));
  EXPECT_EQ(log.waiting[0].value, (std::array<double, 2>{7.0, 7.0}));
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
