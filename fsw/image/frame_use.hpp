// What became of a frame.
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
