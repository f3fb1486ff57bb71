// Packets out of a stream of octets that may be damaged: finds the next whole packet and says what
// lies between.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "bus/layout.hpp"

namespace polhode::bus {

enum class PieceKind : std::uint8_t {
  kPacket,      ///< fixed bits, length and CRC are right
  kDamaged,     ///< octets that belong to no whole packet
  kIncomplete,  ///< the front of what may be a packet; more octets are needed to tell (never with
                ///< the end known)
};

struct StreamPiece {
  PieceKind kind = PieceKind::kDamaged;
  std::size_t offset = 0;
  std::size_t octets = 0;
  PacketHeader header;  ///< of a kPacket
};

/// The piece that starts at `offset` (< stream.size()). Pieces follow each other without gaps or
/// overlaps: go on at piece.offset + piece.octets; a kIncomplete one reaches to the end and is
/// asked for again with more octets. Any damage loses at most the packets that it touches: the
/// search goes on octet by octet from the first bad one.
/// @param at_end  no more octets will come: an incomplete packet is damage, too.
/// @cost  one CRC per place that looks like a header; noise looks like one with probability 2^-27
/// (22 fixed bits,
///        length), and passes the CRC as well with 2^-43.
StreamPiece next_piece(std::span<const std::uint8_t> stream, std::size_t offset, bool at_end);

}  // namespace polhode::bus
