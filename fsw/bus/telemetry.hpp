// Telemetry packets: structs of the field table (packets.hpp) to octets and back, and the packets
// of one step, end to end.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/result.hpp"
#include "bus/capacities.hpp"
#include "bus/layout.hpp"
#include "bus/options.hpp"
#include "bus/packets.hpp"
#include "motion/motion_state.hpp"

namespace polhode {

inline constexpr std::size_t kMotionPacketOctets = bus::motion_layout::kPacketOctets;

namespace bus {

/// What a packet's header is made from.
struct Envelope {
  int apid_first = BusOptions{}.apid_first;
  std::uint16_t sequence = 0;  ///< only its 14 low bits are used
  std::int64_t timestamp_ns = 0;
};

/// Sanitises the packet (see fields.hpp), then writes header, fields and CRC into the front of
/// `out`.
/// @return octets written, or 0 (nothing written) when `out` is shorter than the layout.
std::size_t encode(const Layout& layout,
                   void* packet,
                   const Envelope& envelope,
                   std::span<std::uint8_t> out);

/// Reads exactly one packet of this layout.
/// @errors BadParameter: length, header, layout version, CRC, or a value out of the field table's
/// range; the message names the failed check.
Result<PacketHeader> decode(const Layout& layout,
                            std::span<const std::uint8_t> octets,
                            void* packet);

/// The packets of one step and the counts of all APIDs. Packets are counted with or without room
/// and readers, so that a reader can count the missing ones.
struct PacketStream {
  std::array<std::uint8_t, limits::kStepOctets> octets{};
  std::size_t size = 0;
  std::array<std::uint16_t, kPacketKinds> sequence{};
  std::uint32_t not_sent = 0;  ///< packets for which there was no room

  [[nodiscard]] std::span<const std::uint8_t> view() const {
    return std::span<const std::uint8_t>(octets).first(size);
  }
};

/// @return false when there was no room: the packet is lost, counted in its sequence and in
/// `not_sent`.
bool append(const Layout& layout,
            void* packet,
            std::int64_t timestamp_ns,
            const BusOptions& options,
            PacketStream* stream);

/// The same for a packet of the table, which is sanitised in place.
template <typename Packet>
bool append(Packet& packet, const BusOptions& options, PacketStream* stream) {
  return append(Packet::layout(), &packet, packet.timestamp_ns, options, stream);
}

/// The motion state as a packet. Values whose flag is down are sent as zeros (scale_known only
/// names the unit of lengths). The flag of a value that is not finite goes down.
MotionPacket to_packet(const MotionState& state);

}  // namespace bus

}  // namespace polhode
