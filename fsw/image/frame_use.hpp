// The use of a frame: processed, or skipped for a reason.
#pragma once

#include <cstdint>

namespace polhode {

/// Why a frame was not used, or that it was.
enum class FrameUse : std::uint8_t {
  kUsed,
  kUnreadable,
  kDark,
  kWrongSize,
  kTimeNotIncreasing,
  kHeld,
  kFlat,
  kSaturated,
  kFrozen,
  kTorn,
  kBitErrors
};

}  // namespace polhode
