// The verdict on a frame, as plain data.
#pragma once

#include <cstddef>
#include <cstdint>

namespace polhode {

/// Faults of a frame.
enum class FrameFault : std::uint8_t {
  kNone,
  kDark,       ///< nothing bright, or far darker than the frames before
  kFlat,       ///< no contrast
  kSaturated,  ///< far more of the lit pixels are saturated than in the frames before
  kFrozen,     ///< the previous frame again
  kTorn,       ///< part of it is the previous frame's
  kBitErrors,  ///< single pixels, lines or blocks that are not of this image
  kBlurred,    ///< far less sharp than the frames before
};
inline constexpr std::size_t kFrameFaults = 8;  // as many as the enumeration has

/// Use of the frame. kCare: a degraded frame, pose only; nothing of it enters the map.
enum class FrameDecision : std::uint8_t { kUse, kCare, kSkip };

struct FrameVerdict {
  FrameDecision decision = FrameDecision::kUse;
  FrameFault fault = FrameFault::kNone;  ///< of the gravest faults the first in the order of
                                         ///< precedence
  std::uint16_t faults = 0;              ///< bit n: FrameFault n was found
  float measure = 0.0F;                  ///< value that the fault was decided by
  float limit = 0.0F;                    ///< that `measure` was compared with
};

}  // namespace polhode
