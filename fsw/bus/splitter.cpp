#include "bus/splitter.hpp"

#include "base/assert.hpp"
#include "config/limits.hpp"

namespace polhode::bus {
namespace {

enum class Verdict { kWhole, kNotAPacket, kNeedsMore };

Verdict judge(std::span<const std::uint8_t> rest, PacketHeader& header) {
  if (rest.size() < kHeaderOctets) {
    // Too short to be read: check the fixed bits that are there (see read_header).
    const bool plausible = (rest[0] & 0xF8U) == 0x08U &&
                           (rest.size() < 3 || (rest[2] & 0xC0U) == 0xC0U) &&
                           (rest.size() < 7 || rest[6] == kTimePField);
    return plausible ? Verdict::kNeedsMore : Verdict::kNotAPacket;
  }
  if (!read_header(rest, header) || header.total_octets > limits::kPacketOctets) {
    return Verdict::kNotAPacket;
  }
  if (rest.size() < header.total_octets) {
    return Verdict::kNeedsMore;
  }
  return crc_is_right(rest.first(header.total_octets)) ? Verdict::kWhole : Verdict::kNotAPacket;
}

}  // namespace

StreamPiece next_piece(std::span<const std::uint8_t> stream, std::size_t offset, bool at_end) {
  POLHODE_ASSERT(offset < stream.size(), offset);
  StreamPiece piece{.kind = PieceKind::kDamaged, .offset = offset, .octets = 0, .header = {}};
  for (std::size_t i = offset; i < stream.size(); ++i) {
    PacketHeader header;
    const Verdict verdict = judge(stream.subspan(i), header);
    if (verdict == Verdict::kNotAPacket || (verdict == Verdict::kNeedsMore && at_end)) {
      continue;
    }
    if (i > offset) {  // the damage first; what follows is the next piece
      piece.octets = i - offset;
      return piece;
    }
    piece.kind = verdict == Verdict::kWhole ? PieceKind::kPacket : PieceKind::kIncomplete;
    piece.octets = verdict == Verdict::kWhole ? header.total_octets : stream.size() - offset;
    piece.header = header;
    return piece;
  }
  piece.octets = stream.size() - offset;
  return piece;
}

}  // namespace polhode::bus
