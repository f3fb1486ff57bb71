#include "bus/telemetry.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace polhode {
namespace {

namespace layout = bus::motion_layout;

template <std::size_t kCount>
bool all_finite(const std::array<double, kCount>& values, double sigma) {
  return std::isfinite(sigma) && std::all_of(values.begin(), values.end(), [](double value) {
           return std::isfinite(value);
         });
}

template <std::size_t kCount>
void put_array(std::span<std::uint8_t> out,
               std::size_t offset,
               const std::array<double, kCount>& values) {
  for (std::size_t i = 0; i < kCount; ++i) {
    bus::put_f64(out, offset + 8 * i, values[i]);
  }
}

template <std::size_t kCount>
bool get_array(std::span<const std::uint8_t> in,
               std::size_t offset,
               std::array<double, kCount>& values) {
  for (std::size_t i = 0; i < kCount; ++i) {
    values[i] = bus::get_f64(in, offset + 8 * i);
  }
  return all_finite(values, 0.0);
}

bool get_finite(std::span<const std::uint8_t> in, std::size_t offset, double& value) {
  value = bus::get_f64(in, offset);
  return std::isfinite(value);
}

Error refused(const char* what) { return {.code = ErrorCode::kBadParameter, .message = what}; }

/// Writes the estimates whose values are usable and returns the flags that say so.
std::uint8_t put_estimates(const MotionState& state, std::span<std::uint8_t> out) {
  unsigned flags = 0;
  if (state.pose_valid && all_finite(state.q_CT, state.sigma_att_rad) &&
      all_finite(state.p_CT, state.sigma_pos)) {
    flags |= layout::kFlagPose;
    put_array(out, layout::kAttitude_q_CT, state.q_CT);
    put_array(out, layout::kPosition_p_CT, state.p_CT);
    bus::put_f64(out, layout::kSigmaAttitude_rad, state.sigma_att_rad);
    bus::put_f64(out, layout::kSigmaPosition, state.sigma_pos);
  }
  if (state.rate_valid && all_finite(state.w_T_rad_s, state.sigma_rate_rad_s)) {
    flags |= layout::kFlagRate;
    put_array(out, layout::kRate_w_T_rad_s, state.w_T_rad_s);
    bus::put_f64(out, layout::kSigmaRate_rad_s, state.sigma_rate_rad_s);
  }
  if (state.velocity_valid && all_finite(state.v_C, state.sigma_vel)) {
    flags |= layout::kFlagVelocity;
    put_array(out, layout::kVelocity_v_C, state.v_C);
    bus::put_f64(out, layout::kSigmaVelocity, state.sigma_vel);
  }
  if (state.scale_known) {
    flags |= layout::kFlagScale;
  }
  return static_cast<std::uint8_t>(flags);
}

/// Reads what the flags declare valid. False when such a value is not finite.
bool get_estimates(std::span<const std::uint8_t> in, unsigned flags, MotionState& state) {
  bool finite = true;
  state.pose_valid = (flags & layout::kFlagPose) != 0;
  state.rate_valid = (flags & layout::kFlagRate) != 0;
  state.velocity_valid = (flags & layout::kFlagVelocity) != 0;
  state.scale_known = (flags & layout::kFlagScale) != 0;
  if (state.pose_valid) {
    finite = get_array(in, layout::kAttitude_q_CT, state.q_CT) && finite;
    finite = get_array(in, layout::kPosition_p_CT, state.p_CT) && finite;
    finite = get_finite(in, layout::kSigmaAttitude_rad, state.sigma_att_rad) && finite;
    finite = get_finite(in, layout::kSigmaPosition, state.sigma_pos) && finite;
  }
  if (state.rate_valid) {
    finite = get_array(in, layout::kRate_w_T_rad_s, state.w_T_rad_s) && finite;
    finite = get_finite(in, layout::kSigmaRate_rad_s, state.sigma_rate_rad_s) && finite;
  }
  if (state.velocity_valid) {
    finite = get_array(in, layout::kVelocity_v_C, state.v_C) && finite;
    finite = get_finite(in, layout::kSigmaVelocity, state.sigma_vel) && finite;
  }
  return finite;
}

}  // namespace

std::size_t encode_motion(const MotionState& state,
                          const BusOptions& options,
                          std::uint16_t sequence,
                          std::span<std::uint8_t> out) {
  POLHODE_ASSERT(options.apid_motion >= 1 && options.apid_motion <= bus::kApidMax,
                 options.apid_motion);
  if (out.size() < kMotionPacketOctets) {
    return 0;
  }
  const std::span<std::uint8_t> packet = out.first(kMotionPacketOctets);
  std::fill(packet.begin(), packet.end(), std::uint8_t{0});
  bus::PacketHeader header{.apid = static_cast<std::uint16_t>(options.apid_motion),
                           .sequence = sequence,
                           .total_octets = kMotionPacketOctets};
  bus::set_time(state.timestamp_ns, header);
  bus::write_header(header, packet);
  bus::put_i64(packet, layout::kTimestamp_ns, state.timestamp_ns);
  bus::put_u8(packet, layout::kFlags, put_estimates(state, packet));
  bus::put_u8(packet, layout::kMode, static_cast<std::uint8_t>(state.mode));
  bus::put_u32(packet, layout::kFrame, state.frame);
  bus::put_u16(packet, layout::kFeatures, state.features);
  bus::put_u16(packet, layout::kMatches, state.matches);
  bus::put_u16(packet, layout::kInliers, state.inliers);
  bus::put_u16(packet, layout::kLandmarks, state.landmarks);
  bus::put_u16(packet, layout::kKeyframes, state.keyframes);
  bus::write_crc(packet);
  return kMotionPacketOctets;
}

Result<MotionState> decode_motion(std::span<const std::uint8_t> packet) {
  bus::PacketHeader header;
  if (packet.size() != kMotionPacketOctets) {
    return refused("motion packet: length is not 178 octets");
  }
  if (!bus::read_header(packet, header) || header.total_octets != packet.size()) {
    return refused("motion packet: header damaged");
  }
  if (!bus::crc_is_right(packet)) {
    return refused("motion packet: CRC differs");
  }
  if (header.layout_version != bus::kLayoutVersion) {
    return refused("motion packet: unknown layout version");
  }
  const unsigned mode = bus::get_u8(packet, layout::kMode);
  const unsigned flags = bus::get_u8(packet, layout::kFlags);
  if (mode > static_cast<unsigned>(Mode::kLost) || (flags & ~unsigned{layout::kFlagsUsed}) != 0) {
    return refused("motion packet: unknown mode or flag");
  }
  MotionState state;
  state.timestamp_ns = bus::get_i64(packet, layout::kTimestamp_ns);
  state.mode = static_cast<Mode>(mode);
  state.frame = bus::get_u32(packet, layout::kFrame);
  state.features = bus::get_u16(packet, layout::kFeatures);
  state.matches = bus::get_u16(packet, layout::kMatches);
  state.inliers = bus::get_u16(packet, layout::kInliers);
  state.landmarks = bus::get_u16(packet, layout::kLandmarks);
  state.keyframes = bus::get_u16(packet, layout::kKeyframes);
  if (!get_estimates(packet, flags, state)) {
    return refused("motion packet: a value declared valid is not finite");
  }
  return state;
}

}  // namespace polhode
