#include "recording/segments.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>

#include "errors.hpp"

namespace polhode::platform {

namespace fs = std::filesystem;

namespace {

bool is_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos;
}

/// recording-TIME-NUMBER.rec. A file of another name is somebody's; the oldest segments are
/// removed.
bool is_segment(std::string_view name) {
  constexpr std::string_view kBegin = "recording-";
  constexpr std::string_view kEnd = ".rec";
  if (!name.starts_with(kBegin) || !name.ends_with(kEnd)) {
    return false;
  }
  name = name.substr(kBegin.size(), name.size() - kBegin.size() - kEnd.size());
  const std::size_t dash = std::min(name.find('-'), name.size() - 1);
  return is_number(name.substr(0, dash)) && is_number(name.substr(dash + 1));
}

}  // namespace

std::vector<fs::path> segment_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code problem;
  fs::directory_iterator entries(folder, problem);
  if (problem) {
    throw UnusableInput(fmt::format("{}: cannot be read: {}", folder.string(), problem.message()));
  }
  for (const auto& entry : entries) {
    if (is_segment(entry.path().filename().string())) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

Segments::Segments(const fs::path& folder, std::int64_t run_utc_ns, const SegmentLimits& limits)
    : folder_(folder), run_utc_ns_(run_utc_ns), limits_(limits) {
  std::error_code problem;
  fs::create_directories(folder, problem);
  folder_descriptor_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_descriptor_ < 0) {
    throw RunFailure(fmt::format("{}: cannot be used for a recording: {}",
                                 folder.string(),
                                 std::generic_category().message(errno)));
  }
  const std::vector<fs::path> present = segment_files(folder);
  segments_.reserve(present.size() + limits.folder_bytes_max / limits.segment_bytes_max + 2);
  for (const fs::path& file : present) {
    Segment segment;
    std::snprintf(segment.name.data(), segment.name.size(), "%s", file.filename().c_str());
    segment.bytes = fs::file_size(file, problem);
    folder_bytes_ += segment.bytes;
    segments_.push_back(segment);
  }
}

Segments::~Segments() {
  if (file_ >= 0) {
    ::close(file_);
  }
  ::close(folder_descriptor_);
}

bool Segments::wants_next(std::uint64_t bytes) const {
  return file_ < 0 || segments_.back().bytes + bytes > limits_.segment_bytes_max;
}

void Segments::remove_oldest() {
  (void)::unlinkat(folder_descriptor_, segments_.front().name.data(), 0);
  folder_bytes_ -= segments_.front().bytes;
  segments_.erase(segments_.begin());
  ++removed_;
}

bool Segments::begin_next() {
  if (file_ >= 0) {
    ::close(file_);
    file_ = -1;
  }
  while (!segments_.empty() &&
         (folder_bytes_ + limits_.segment_bytes_max > limits_.folder_bytes_max ||
          segments_.size() == segments_.capacity())) {
    remove_oldest();
  }
  Segment segment;
  std::snprintf(segment.name.data(),
                segment.name.size(),
                "recording-%019lld-%06u.rec",
                static_cast<long long>(run_utc_ns_),
                ++number_);
  file_ = ::openat(folder_descriptor_,
                   segment.name.data(),
                   O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC,
                   0640);
  if (file_ < 0) {
    return false;
  }
  segments_.push_back(segment);
  return true;
}

void Segments::abandon_present() {
  ::close(file_);
  file_ = -1;
  (void)::unlinkat(folder_descriptor_, segments_.back().name.data(), 0);
  folder_bytes_ -= segments_.back().bytes;
  segments_.pop_back();
}

bool Segments::write(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file_, bytes.data(), bytes.size());
    if (written <= 0) {
      return false;
    }
    const auto taken = static_cast<std::size_t>(written);
    segments_.back().bytes += taken;
    folder_bytes_ += taken;
    bytes = bytes.subspan(taken);
  }
  return true;
}

}  // namespace polhode::platform
