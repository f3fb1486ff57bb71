#include "bus/splitter.hpp"

#include "base/assert.hpp"
#include "config/limits.hpp"

namespace polhode::bus {
namespace {

enum class Verdict { kWhole, kIdle, kNotAPacket, kNeedsMore };

PieceKind kind_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kWhole:
      return PieceKind::kPacket;
    case Verdict::kIdle:
      return PieceKind::kIdle;
    case Verdict::kNeedsMore:
      return PieceKind::kIncomplete;
    case Verdict::kNotAPacket:
      break;
  }
  return PieceKind::kDamaged;
}

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

/// An idle packet, with the beginning of what follows where that is there.
Verdict judge_idle(std::span<const std::uint8_t> rest, PacketHeader& header) {
  constexpr std::size_t kIdleOctetsMax = 4096;  // a longer one could hide packets
  const bool plausible = rest[0] == 0x07 && (rest.size() < 2 || rest[1] == 0xFF) &&
                         (rest.size() < 3 || (rest[2] & 0xC0U) == 0xC0U);
  if (!plausible || rest.size() < kPrimaryHeaderOctets) {
    return plausible ? Verdict::kNeedsMore : Verdict::kNotAPacket;
  }
  header.total_octets = get_u16(rest, 4) + kLengthOffset;
  if (header.total_octets > kIdleOctetsMax) {
    return Verdict::kNotAPacket;
  }
  if (rest.size() <= header.total_octets) {
    return rest.size() == header.total_octets ? Verdict::kIdle : Verdict::kNeedsMore;
  }
  const std::uint8_t next = rest[header.total_octets];
  return next == 0x07 || (next & 0xF8U) == 0x08U ? Verdict::kIdle : Verdict::kNotAPacket;
}

}  // namespace

StreamPiece next_piece(std::span<const std::uint8_t> stream, std::size_t offset, bool at_end) {
  POLHODE_ASSERT(offset < stream.size(), offset);
  StreamPiece piece{.kind = PieceKind::kDamaged, .offset = offset, .octets = 0, .header = {}};
  for (std::size_t i = offset; i < stream.size(); ++i) {
    PacketHeader header;
    Verdict verdict = judge(stream.subspan(i), header);
    if (verdict == Verdict::kNotAPacket) {
      verdict = judge_idle(stream.subspan(i), header);
    }
    if (verdict == Verdict::kNotAPacket || (verdict == Verdict::kNeedsMore && at_end)) {
      continue;
    }
    if (i > offset) {  // the damage first; what follows is the next piece
      piece.octets = i - offset;
      return piece;
    }
    piece.kind = kind_of(verdict);
    piece.octets = verdict == Verdict::kNeedsMore ? stream.size() - offset : header.total_octets;
    piece.header = header;
    return piece;
  }
  piece.octets = stream.size() - offset;
  return piece;
}

}  // namespace polhode::bus
