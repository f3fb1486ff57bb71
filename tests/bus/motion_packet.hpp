// One motion packet by itself, written and read back: for tests and benchmarks of what carries
// packets.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "bus/telemetry.hpp"

namespace polhode {
namespace bus {

template <std::size_t kCount>
inline std::array<double, kCount> widened(const std::array<float, kCount>& values) {
  std::array<double, kCount> out{};
  std::copy(values.begin(), values.end(), out.begin());
  return out;
}

inline bool has(std::uint8_t flags, std::uint8_t flag) { return (flags & flag) != 0; }

/// @return MotionState's defaults for fields whose flag is down, the scale's number modulo 16.
inline MotionState from_packet(const MotionPacket& packet) {
  namespace flag = motion_layout;
  MotionState state;
  state.frame = packet.frame;
  state.timestamp_ns = packet.timestamp_ns;
  state.mode = static_cast<Mode>(packet.mode);
  state.scale_known = has(packet.flags, flag::kFlagScaleKnown);
  state.scale_number = static_cast<std::uint32_t>(packet.flags) >> flag::kScaleNumberShift;
  state.features = packet.features;
  state.matches = packet.matches;
  state.inliers = packet.inliers;
  state.landmarks = packet.landmarks;
  state.keyframes = packet.keyframes;
  if (has(packet.flags, flag::kFlagPose)) {
    state.pose_valid = true;
    state.q_CT = packet.q_CT;
    state.p_CT = packet.p_CT;
    state.sigma_att_rad = packet.sigma_att_rad;
    state.sigma_pos = packet.sigma_pos;
    state.cov_pose = widened(packet.cov_pose);
  }
  if (has(packet.flags, flag::kFlagRate)) {
    state.rate_valid = true;
    state.w_T_rad_s = packet.w_T_rad_s;
    state.sigma_rate_rad_s = packet.sigma_rate_rad_s;
    state.cov_w = widened(packet.cov_w);
  }
  if (has(packet.flags, flag::kFlagVelocity)) {
    state.velocity_valid = true;
    state.v_C = packet.v_C;
    state.sigma_vel = packet.sigma_vel;
    state.cov_v = widened(packet.cov_v);
  }
  return state;
}

}  // namespace bus

/// @return octets written, or 0 (nothing written) when `out` is shorter than kMotionPacketOctets.
inline std::size_t encode_motion(const MotionState& state,
                                 const BusOptions& options,
                                 std::uint16_t sequence,
                                 std::span<std::uint8_t> out) {
  bus::MotionPacket packet = bus::to_packet(state);
  return bus::encode(
      bus::MotionPacket::layout(),
      &packet,
      {.apid_first = options.apid_first, .sequence = sequence, .timestamp_ns = state.timestamp_ns},
      out);
}

/// Reads exactly one motion packet. @errors as bus::decode().
inline Result<MotionState> decode_motion(std::span<const std::uint8_t> octets) {
  bus::MotionPacket packet;
  const Result<bus::PacketHeader> header =
      bus::decode(bus::MotionPacket::layout(), octets, &packet);
  if (!header) {
    return header.error();
  }
  return bus::from_packet(packet);
}

}  // namespace polhode
