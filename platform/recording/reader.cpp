#include "recording/reader.hpp"

#include <fmt/format.h>
#include <lz4.h>

#include <charconv>

#include "base/crc.hpp"
#include "camera/replay/file_bytes.hpp"
#include "config/limits.hpp"
#include "errors.hpp"
#include "recording/segments.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

/// From "recording-<start>-<number>.rec". @return false when it is none.
bool parse_name(const fs::path& file, std::int64_t* utc_ns, std::uint32_t* number) {
  const std::string name = file.stem();
  const std::size_t dash = name.rfind('-');
  constexpr std::size_t kBegin = 10;  // after "recording-"
  if (dash == std::string::npos || dash <= kBegin) {
    return false;
  }
  const char* begin = name.data();
  const bool start = std::from_chars(begin + kBegin, begin + dash, *utc_ns).ec == std::errc{};
  return start && std::from_chars(begin + dash + 1, begin + name.size(), *number).ec == std::errc{};
}

/// A whole number of the run's parameters. @return 0 when it is not there.
std::size_t parameter_of(std::string_view text, std::string_view key) {
  const std::size_t at = text.find(key);
  std::size_t value = 0;
  if (at != std::string_view::npos) {
    (void)std::from_chars(text.data() + at + key.size(), text.data() + text.size(), value);
  }
  return value;
}

/// Of a frame of the camera that the run's parameters name, 16 bits a pixel.
/// @return `otherwise` where they name none that can be.
std::size_t frame_bytes_of(std::span<const std::uint8_t> begin, std::size_t otherwise) {
  const std::string_view text(reinterpret_cast<const char*>(begin.data()), begin.size());
  const std::size_t width = parameter_of(text, "\ncamera.width_px = ");
  const std::size_t height = parameter_of(text, "\ncamera.height_px = ");
  const bool known =
      width > 0 && height > 0 && width <= limits::kImageSide && height <= limits::kImageSide;
  return known ? 2 * width * height : otherwise;
}

}  // namespace

std::vector<RecordedRun> recorded_runs(const fs::path& folder) {
  std::vector<RecordedRun> runs;
  std::error_code problem;
  if (!fs::is_directory(folder, problem)) {
    throw UnusableInput(fmt::format("{}: no such folder", folder.string()));
  }
  std::uint32_t last = 0;
  for (const fs::path& file : segment_files(folder)) {
    std::int64_t utc_ns = 0;
    std::uint32_t number = 0;
    if (!parse_name(file, &utc_ns, &number)) {
      continue;
    }
    if (runs.empty() || runs.back().utc_ns != utc_ns) {
      runs.push_back({.utc_ns = utc_ns, .files = {}, .begins = number == 1});
    } else {
      runs.back().files_missing += number > last ? number - last - 1 : 0;
    }
    runs.back().files.push_back(file);
    last = number;
  }
  if (runs.empty()) {
    throw UnusableInput(fmt::format("{}: holds no recording", folder.string()));
  }
  return runs;
}

bool unpack(const RecordHeader& header, std::size_t bytes_max, std::vector<std::uint8_t>* content) {
  const std::size_t pixels = static_cast<std::size_t>(header.width_px) * header.height_px;
  const std::size_t bytes = header.deep ? 2 * pixels : pixels;
  // No LZ4 block unpacks to more than 255 times its length: a size beyond that is no image's.
  constexpr std::size_t kLz4Ratio = 255;
  if (bytes > bytes_max || bytes > kLz4Ratio * (content->size() + 1)) {
    return false;
  }
  if (header.packing == RecordPacking::kDifferenceLz4) {
    std::vector<std::uint8_t> image(bytes);
    const int got = LZ4_decompress_safe(reinterpret_cast<const char*>(content->data()),
                                        reinterpret_cast<char*>(image.data()),
                                        static_cast<int>(content->size()),
                                        static_cast<int>(bytes));
    if (got != static_cast<int>(bytes)) {
      return false;
    }
    sum_rows(image, header.width_px, header.deep);
    content->swap(image);
  }
  return content->size() == bytes;
}

bool RecordingReader::open_next_file() {
  while (next_file_ < run_.files.size()) {
    at_ = 0;
    if (!read_file(run_.files[next_file_++], bytes_)) {
      return true;
    }
    ++files_lost_;
  }
  return false;
}

/// To the next place where a record begins.
void RecordingReader::pass_over(std::uint64_t from) {
  ++at_;
  while (at_ < bytes_.size() && !decode_record_header(std::span(bytes_).subspan(at_))) {
    ++at_;
  }
  bytes_lost_ += at_ - from;
}

bool RecordingReader::read_record(Record* record) {
  const auto rest = std::span<const std::uint8_t>(bytes_).subspan(at_);
  const auto header = decode_record_header(rest);
  if (!header || rest.size() - kRecordHeaderBytes < header->bytes) {
    return false;
  }
  const auto content = rest.subspan(kRecordHeaderBytes, header->bytes);
  if (crc32_iso_hdlc(content) != header->content_crc32) {
    return false;
  }
  record->header = *header;
  record->content.assign(content.begin(), content.end());
  const bool has_image = header->kind == RecordKind::kFrame && header->readable;
  if (has_image && !unpack(*header, frame_bytes_max_, &record->content)) {
    return false;
  }
  if (header->kind == RecordKind::kBegin) {
    frame_bytes_max_ = frame_bytes_of(record->content, frame_bytes_max_);
  }
  at_ += kRecordHeaderBytes + header->bytes;
  return true;
}

bool RecordingReader::next(Record* record) {
  for (;;) {
    if (at_ >= bytes_.size()) {
      if (!open_next_file()) {
        return false;
      }
      continue;
    }
    if (read_record(record)) {
      return true;
    }
    pass_over(at_);
  }
}

}  // namespace polhode::platform
