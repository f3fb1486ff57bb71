#include "bus/splitter.hpp"

#include <algorithm>

#include "base/assert.hpp"
#include "bus/packets.hpp"
#include "config/limits.hpp"

namespace polhode::bus {
namespace {

enum class Verdict { kWhole, kIdle, kForeign, kNotAPacket, kNeedsMore };

constexpr std::size_t kSkippedOctetsMax = 4096;  // a longer one could hide packets

PieceKind kind_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kWhole:
      return PieceKind::kPacket;
    case Verdict::kIdle:
      return PieceKind::kIdle;
    case Verdict::kForeign:
      return PieceKind::kForeign;
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

/// Checks an idle packet, and the beginning of the next packet where it is in the stream.
Verdict judge_idle(std::span<const std::uint8_t> rest, PacketHeader& header) {
  const bool plausible = rest[0] == 0x07 && (rest.size() < 2 || rest[1] == 0xFF) &&
                         (rest.size() < 3 || (rest[2] & 0xC0U) == 0xC0U);
  if (!plausible || rest.size() < kPrimaryHeaderOctets) {
    return plausible ? Verdict::kNeedsMore : Verdict::kNotAPacket;
  }
  header.total_octets = get_u16(rest, 4) + kLengthOffset;
  if (header.total_octets > kSkippedOctetsMax) {
    return Verdict::kNotAPacket;
  }
  if (rest.size() <= header.total_octets) {
    return rest.size() == header.total_octets ? Verdict::kIdle : Verdict::kNeedsMore;
  }
  const std::uint8_t next = rest[header.total_octets];
  return next == 0x07 || (next & 0xF8U) == 0x08U ? Verdict::kIdle : Verdict::kNotAPacket;
}

/// The possible owner of a primary header.
enum class Owner { kNobody, kRun, kFill, kOther };

Owner owner_of(std::span<const std::uint8_t> header, int apid_first) {
  const bool is_telemetry = (header[0] & 0x10U) == 0;
  const bool is_unsegmented = (header[2] & 0xC0U) == 0xC0U;
  const int apid = get_u16(header, 0) & 0x7FF;
  if ((header[0] & 0xE0U) != 0) {  // the version
    return Owner::kNobody;
  }
  if (apid == 0x7FF) {
    return header[0] == 0x07 && is_unsegmented ? Owner::kFill : Owner::kNobody;
  }
  if (apid >= apid_first && apid <= apid_first + kCommandApid && is_telemetry) {
    return (header[0] & 0xF8U) == 0x08U && is_unsegmented ? Owner::kRun : Owner::kNobody;
  }
  // A hole in a file reads as zeros.
  return std::any_of(header.begin(), header.end(), [](std::uint8_t octet) { return octet != 0; })
             ? Owner::kOther
             : Owner::kNobody;
}

/// Checks a packet of another application, or an idle packet before one. It is followed by its
/// length to the next few headers, which must be plausible.
Verdict judge_skipped(std::span<const std::uint8_t> rest,
                      int apid_first,
                      bool at_end,
                      PacketHeader& header) {
  constexpr int kLookAhead = 4;  // packets; each makes an accident some ten times less likely
  const Verdict skipped =
      rest[0] == 0x07 && rest.size() > 1 && rest[1] == 0xFF ? Verdict::kIdle : Verdict::kForeign;
  std::size_t at = 0;
  for (int i = 0; i < kLookAhead; ++i) {
    if (i > 0 && at == rest.size()) {
      return at_end ? skipped : Verdict::kNeedsMore;
    }
    if (rest.size() - at < kPrimaryHeaderOctets) {
      return at_end ? Verdict::kNotAPacket : Verdict::kNeedsMore;
    }
    const Owner owner = owner_of(rest.subspan(at, kPrimaryHeaderOctets), apid_first);
    if (i > 0 && (owner == Owner::kRun || owner == Owner::kFill)) {
      return skipped;
    }
    const std::size_t octets = get_u16(rest, at + 4) + kLengthOffset;
    if (owner == Owner::kNobody || owner == Owner::kRun || octets > kSkippedOctetsMax) {
      return Verdict::kNotAPacket;
    }
    header.total_octets = i == 0 ? octets : header.total_octets;
    at += octets;
    if (at > rest.size()) {
      return at_end ? Verdict::kNotAPacket : Verdict::kNeedsMore;
    }
  }
  return skipped;
}

/// @param in_step  packets were whole up to here.
Verdict judge_any(std::span<const std::uint8_t> rest,
                  int apid_first,
                  bool at_end,
                  bool in_step,
                  PacketHeader& header) {
  const auto is_none = [at_end](Verdict verdict) {
    return verdict == Verdict::kNotAPacket || (verdict == Verdict::kNeedsMore && at_end);
  };
  Verdict verdict = judge(rest, header);
  if (is_none(verdict)) {
    verdict = judge_idle(rest, header);
  }
  if (is_none(verdict) && in_step) {
    verdict = judge_skipped(rest, apid_first, at_end, header);
  }
  return is_none(verdict) ? Verdict::kNotAPacket : verdict;
}

}  // namespace

StreamPiece next_piece(std::span<const std::uint8_t> stream,
                       std::size_t offset,
                       bool at_end,
                       const StreamPlace& place) {
  POLHODE_ASSERT(offset < stream.size(), offset);
  StreamPiece piece{.kind = PieceKind::kDamaged, .offset = offset, .octets = 0, .header = {}};
  for (std::size_t i = offset; i < stream.size(); ++i) {
    PacketHeader header;
    const bool in_step = i == offset && !place.after_damage;
    const Verdict verdict = judge_any(stream.subspan(i), place.apid_first, at_end, in_step, header);
    if (verdict == Verdict::kNotAPacket) {
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
