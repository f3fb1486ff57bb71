// Finds the whole packets in a stream of octets with possible damage, and the pieces between them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "bus/layout.hpp"

namespace polhode::bus {

enum class PieceKind : std::uint8_t {
  kPacket,      ///< fixed bits, length and CRC are right
  kIdle,        ///< a CCSDS idle packet: it fills up a frame and has no content
  kForeign,     ///< a packet of another application, without our secondary header or CRC
  kDamaged,     ///< octets that belong to no whole packet
  kIncomplete,  ///< the front of a possible packet; more octets are needed (never with at_end)
};

struct StreamPiece {
  PieceKind kind = PieceKind::kDamaged;
  std::size_t offset = 0;
  std::size_t octets = 0;
  PacketHeader header;  ///< of a kPacket
};

/// What precedes a piece, and the APIDs of the run.
struct StreamPlace {
  /// The piece before was damage. Then only a CRC shows where a packet begins: a header of another
  /// application is not accepted.
  bool after_damage = false;
  int apid_first = 0x1A0;  ///< of the run: headers with its 16 APIDs are its packets, or damage
};

/// The piece that starts at `offset` (< stream.size()). Pieces have no gaps or overlaps: continue
/// at piece.offset + piece.octets. A kIncomplete one reaches to the end; ask again with more
/// octets. Damage loses only the packets that it touches: the search continues octet by octet after
/// the first bad one.
/// A packet of another application is recognised by its primary header and by the octets after it:
/// another primary header or the end. At most 4096 octets are skipped so: more could hide packets.
/// @param at_end  no more octets will come: an incomplete packet is damage, too.
/// @cost  one CRC per place that looks like a header. Noise does with probability 2^-27 (22 fixed
/// bits and the length), and passes the CRC as well with 2^-43.
StreamPiece next_piece(std::span<const std::uint8_t> stream,
                       std::size_t offset,
                       bool at_end,
                       const StreamPlace& place = {});

}  // namespace polhode::bus
