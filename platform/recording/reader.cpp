#include "recording/reader.hpp"

#include <fmt/format.h>
#include <lz4.h>

#include <charconv>

#include "base/crc.hpp"
#include "camera/replay/file_octets.hpp"
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

}  // namespace

std::vector<RecordedRun> recorded_runs(const fs::path& folder) {
  std::vector<RecordedRun> runs;
  if (!fs::is_directory(folder)) {
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
      runs.back().files_missing += number - last - 1;
    }
    runs.back().files.push_back(file);
    last = number;
  }
  if (runs.empty()) {
    throw UnusableInput(fmt::format("{}: holds no recording", folder.string()));
  }
  return runs;
}

bool unpack(const RecordHeader& header, std::vector<std::uint8_t>* content) {
  const std::size_t pixels = static_cast<std::size_t>(header.width_px) * header.height_px;
  const std::size_t octets = header.deep ? 2 * pixels : pixels;
  if (header.packing == RecordPacking::kDifferenceLz4) {
    std::vector<std::uint8_t> image(octets);
    const int got = LZ4_decompress_safe(reinterpret_cast<const char*>(content->data()),
                                        reinterpret_cast<char*>(image.data()),
                                        static_cast<int>(content->size()),
                                        static_cast<int>(octets));
    if (got != static_cast<int>(octets)) {
      return false;
    }
    sum_rows(image, header.width_px, header.deep);
    content->swap(image);
  }
  return content->size() == octets;
}

bool RecordingReader::open_next_file() {
  while (next_file_ < run_.files.size()) {
    at_ = 0;
    if (!read_file(run_.files[next_file_++], octets_)) {
      return true;
    }
    ++files_lost_;
  }
  return false;
}

/// To the next place where a record begins.
void RecordingReader::pass_over(std::uint64_t from) {
  ++at_;
  while (at_ < octets_.size() && !decode_record_header(std::span(octets_).subspan(at_))) {
    ++at_;
  }
  octets_lost_ += at_ - from;
}

bool RecordingReader::read_record(Record* record) {
  const auto rest = std::span<const std::uint8_t>(octets_).subspan(at_);
  const auto header = decode_record_header(rest);
  if (!header || rest.size() - kRecordHeaderOctets < header->octets) {
    return false;
  }
  const auto content = rest.subspan(kRecordHeaderOctets, header->octets);
  if (crc32_iso_hdlc(content) != header->content_crc32) {
    return false;
  }
  record->header = *header;
  record->content.assign(content.begin(), content.end());
  const bool picture = header->kind == RecordKind::kFrame && header->readable;
  if (picture && !unpack(*header, &record->content)) {
    return false;
  }
  at_ += kRecordHeaderOctets + header->octets;
  return true;
}

bool RecordingReader::next(Record* record) {
  for (;;) {
    if (at_ >= octets_.size()) {
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
