#include "bus/telemetry.hpp"

#include "bus/narrow.hpp"

namespace polhode {
namespace bus {
namespace {

// Rounding to binary32 is 2^-24 = 6e-8 of a value. Chosen above that; larger lets damage pass.
constexpr double kRangeSlack = 1e-6;

Error refused(const Layout& layout, const char* what) {
  return {.code = ErrorCode::kBadParameter,
          .message = std::string(layout.name) + " packet: " + what};
}

}  // namespace

std::size_t encode(const Layout& layout,
                   void* packet,
                   const Envelope& envelope,
                   std::span<std::uint8_t> out) {
  const int apid = envelope.apid_first + layout.number;
  POLHODE_ASSERT(apid >= 1 && apid <= kApidMax, apid);
  if (out.size() < layout.octets) {
    return 0;
  }
  sanitise(layout, packet);
  const std::span<std::uint8_t> octets = out.first(layout.octets);
  PacketHeader header{.apid = static_cast<std::uint16_t>(apid),
                      .sequence = envelope.sequence,
                      .total_octets = layout.octets};
  set_time(envelope.timestamp_ns, &header);
  write_header(header, octets);
  pack_fields(layout, packet, octets);
  write_crc(octets);
  return layout.octets;
}

Result<PacketHeader> decode(const Layout& layout,
                            std::span<const std::uint8_t> octets,
                            void* packet) {
  if (octets.size() != layout.octets) {
    return refused(layout, "length is not the table's");
  }
  PacketHeader header;
  if (!read_header(octets, header) || header.total_octets != octets.size()) {
    return refused(layout, "header damaged");
  }
  if (!crc_is_right(octets)) {
    return refused(layout, "CRC differs");
  }
  if (header.layout_version != kLayoutVersion) {
    return refused(layout, "unknown layout version");
  }
  unpack_fields(layout, octets, packet);
  if (const Field* field = out_of_range(layout, packet, kRangeSlack)) {
    return refused(layout, (std::string(field->name) + " out of range").c_str());
  }
  return header;
}

bool append(const Layout& layout,
            void* packet,
            std::int64_t timestamp_ns,
            const BusOptions& options,
            PacketStream* stream) {
  std::uint16_t& sequence = stream->sequence[layout.number];
  const std::size_t written =
      encode(layout,
             packet,
             {.apid_first = options.apid_first, .sequence = sequence, .timestamp_ns = timestamp_ns},
             std::span(stream->octets).subspan(stream->size));
  sequence = next_sequence(sequence);
  stream->size += written;
  stream->not_sent += written == 0 ? 1U : 0U;
  return written != 0;
}

MotionPacket to_packet(const MotionState& state) {
  namespace flag = motion_layout;
  unsigned flags = 0;
  flags |= state.pose_valid ? flag::kFlagPose : 0U;
  flags |= state.rate_valid ? flag::kFlagRate : 0U;
  flags |= state.velocity_valid ? flag::kFlagVelocity : 0U;
  flags |= state.scale_known ? flag::kFlagScaleKnown : 0U;
  flags |= state.scale_number % flag::kScaleNumbers << flag::kScaleNumberShift;
  return {.timestamp_ns = state.timestamp_ns,
          .q_CT = state.q_CT,
          .p_CT = state.p_CT,
          .v_C = state.v_C,
          .w_T_rad_s = state.w_T_rad_s,
          .sigma_att_rad = state.sigma_att_rad,
          .sigma_pos = state.sigma_pos,
          .sigma_vel = state.sigma_vel,
          .sigma_rate_rad_s = state.sigma_rate_rad_s,
          .cov_pose = narrowed(state.cov_pose),
          .cov_v = narrowed(state.cov_v),
          .cov_w = narrowed(state.cov_w),
          .frame = state.frame,
          .features = state.features,
          .matches = state.matches,
          .inliers = state.inliers,
          .landmarks = state.landmarks,
          .keyframes = state.keyframes,
          .mode = static_cast<std::uint8_t>(state.mode),
          .flags = static_cast<std::uint8_t>(flags)};
}

}  // namespace bus

}  // namespace polhode
