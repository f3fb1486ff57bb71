// What may be wrong with a frame: one row for each, with its counter.
#pragma once

#include <cstdint>

#include "bus/counters.hpp"
#include "image/frame_use.hpp"
#include "image/verdict.hpp"

namespace polhode {

/// Why a frame was not used, or that it was.
struct FrameUseRow {
  FrameUse use;
  std::uint32_t Counters::*counter;  ///< nullptr: it is counted by the image's fault
  bool looked_at;                    ///< there was an image, good or bad, with a time of its own
};

inline constexpr FrameUseRow kFrameUseRows[] = {
    {FrameUse::kUsed, &Counters::frames_used, true},
    {FrameUse::kUnreadable, &Counters::frames_unreadable, false},
    {FrameUse::kWrongSize, &Counters::frames_wrong_size, false},
    {FrameUse::kTimeNotIncreasing, &Counters::frames_time_not_increasing, false},
    {FrameUse::kHeld, &Counters::frames_held, false},
    {FrameUse::kDark, nullptr, true},
    {FrameUse::kFlat, nullptr, true},
    {FrameUse::kSaturated, nullptr, true},
    {FrameUse::kFrozen, nullptr, true},
    {FrameUse::kTorn, nullptr, true},
    {FrameUse::kBitErrors, nullptr, true},
};

/// A fault of an image: counted both if the frame is skipped and if it is used for a pose only.
struct FrameFaultRow {
  FrameFault fault;
  FrameUse skipped;  ///< use of a frame that is skipped for it
  std::uint32_t Counters::*counter;
};

inline constexpr FrameFaultRow kFrameFaultRows[] = {
    {FrameFault::kDark, FrameUse::kDark, &Counters::frames_dark},
    {FrameFault::kFlat, FrameUse::kFlat, &Counters::frames_flat},
    {FrameFault::kSaturated, FrameUse::kSaturated, &Counters::frames_saturated},
    {FrameFault::kFrozen, FrameUse::kFrozen, &Counters::frames_frozen},
    {FrameFault::kTorn, FrameUse::kTorn, &Counters::frames_torn},
    {FrameFault::kBitErrors, FrameUse::kBitErrors, &Counters::frames_bit_errors},
    {FrameFault::kBlurred, FrameUse::kUsed, &Counters::frames_blurred},  // never skipped for it
};

/// The row of a use; every one has one.
constexpr const FrameUseRow& row_of(FrameUse use) {
  for (const FrameUseRow& row : kFrameUseRows) {
    if (row.use == use) {
      return row;
    }
  }
  return kFrameUseRows[0];
}

/// The row of a fault; nullptr of none.
constexpr const FrameFaultRow* row_of(FrameFault fault) {
  for (const FrameFaultRow& row : kFrameFaultRows) {
    if (row.fault == fault) {
      return &row;
    }
  }
  return nullptr;
}

}  // namespace polhode
