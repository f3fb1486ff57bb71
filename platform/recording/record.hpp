// One record of a recording: a header of fixed size, then its content. Little endian, each part
// with a checksum of its own, so that a torn end or a damaged place is found and passed over.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace polhode::platform {

enum class RecordKind : std::uint8_t {
  kBegin = 1,       ///< version and parameters of the run as text; first in every file
  kFrame = 2,       ///< an accepted frame
  kDropped = 3,     ///< a frame that was not accepted: `reason`, `count`
  kCommand = 4,     ///< a command packet, carried out before the frame that follows
  kCheckpoint = 5,  ///< the state that the run started from
};

enum class DropReason : std::uint8_t {
  kLate = 1,         ///< a newer one was there
  kJob = 2,          ///< the work due at it was not finished
  kNotRecorded = 3,  ///< accepted, but the disk was behind: from here on a replay differs
};

enum class RecordPacking : std::uint8_t { kRaw = 0, kDifferenceLz4 = 1 };

inline constexpr std::size_t kRecordHeaderBytes = 40;

struct RecordHeader {
  RecordKind kind = RecordKind::kBegin;
  bool readable = true;  ///< of a frame
  bool deep = false;     ///< 16 bits a pixel
  RecordPacking packing = RecordPacking::kRaw;
  std::uint16_t width_px = 0;
  std::uint16_t height_px = 0;
  std::int64_t timestamp_ns = 0;  ///< of a frame
  DropReason reason = DropReason::kLate;
  std::uint32_t count = 0;
  std::uint32_t bytes = 0;  ///< of the content
  std::uint32_t content_crc32 = 0;
};

std::array<std::uint8_t, kRecordHeaderBytes> encode(const RecordHeader& header);
/// @return nothing when it is no header, a damaged one, or of a kind or size that there is not.
std::optional<RecordHeader> decode_record_header(std::span<const std::uint8_t> bytes);

/// Gray values as differences to the left neighbour, row by row, which compress better; and back.
/// @param to as long as `from`.
void difference_rows(std::span<const std::uint8_t> from, int width_px, bool deep, std::uint8_t* to);
void sum_rows(std::span<std::uint8_t> pixels, int width_px, bool deep);

}  // namespace polhode::platform
