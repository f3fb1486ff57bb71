// The motion packet: one per accepted frame, valid or not. Field table: docs/bus.md.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/result.hpp"
#include "bus/layout.hpp"
#include "bus/options.hpp"
#include "motion/motion_state.hpp"

namespace polhode {

inline constexpr std::size_t kMotionPacketOctets = bus::motion_layout::kPacketOctets;

/// Writes the motion packet of one frame into the front of `out`.
/// What a flag declares invalid goes out as zeros (the scale flag says only which unit lengths
/// have). A value that is not finite takes its flag down: no NaN and no infinity goes on the bus.
/// @param sequence  count of this APID; only its 14 low bits are used. The caller counts with
/// bus::next_sequence().
/// @return octets written, or 0 (nothing written) when `out` is shorter than kMotionPacketOctets.
std::size_t encode_motion(const MotionState& state,
                          const BusOptions& options,
                          std::uint16_t sequence,
                          std::span<std::uint8_t> out);

/// Reads exactly one motion packet. Fields whose flag is down come back with MotionState's
/// defaults.
/// @errors BadParameter: length, header, layout version, CRC, mode, reserved flag, or a value that
/// is not finite; the
///         message says which.
Result<MotionState> decode_motion(std::span<const std::uint8_t> packet);

}  // namespace polhode
