// Reads a recording record by record over its files, skipping damage.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "config/limits.hpp"
#include "recording/record.hpp"

namespace polhode::platform {

struct Record {
  RecordHeader header;
  std::vector<std::uint8_t> content;  ///< of frames: the pixels, unpacked, rows without padding
};

/// A run's files, in order.
struct RecordedRun {
  std::int64_t utc_ns = 0;  ///< when it began
  std::vector<std::filesystem::path> files;
  bool begins = false;  ///< its first file is still there
  std::uint32_t files_missing =
      0;  ///< by their numbers, between the first and the last that are there
};

/// The runs of a folder, oldest first.
/// @throws UnusableInput when there is none.
std::vector<RecordedRun> recorded_runs(const std::filesystem::path& folder);

class RecordingReader {
 public:
  explicit RecordingReader(const RecordedRun& run) : run_(run), files_lost_(run.files_missing) {}

  /// @return false at the end.
  bool next(Record* record);

  /// Bytes that were passed over, because they were damaged or cut off.
  [[nodiscard]] std::uint64_t bytes_lost() const { return bytes_lost_; }
  /// Files that are missing or could not be read.
  [[nodiscard]] std::uint32_t files_lost() const { return files_lost_; }

 private:
  bool open_next_file();
  bool read_record(Record* record);
  void pass_over(std::uint64_t from);

  const RecordedRun& run_;
  std::size_t next_file_ = 0;
  std::vector<std::uint8_t> bytes_;  ///< of the present file
  std::size_t at_ = 0;
  /// Of the run's camera, once the record that names it was read.
  std::size_t frame_bytes_max_ = 2 * limits::kImageSide * limits::kImageSide;
  std::uint64_t bytes_lost_ = 0;
  std::uint32_t files_lost_ = 0;
};

/// The pixels of a frame's record as it is stored.
/// @param bytes_max  no more memory is requested
/// @return false when they cannot be had.
bool unpack(const RecordHeader& header, std::size_t bytes_max, std::vector<std::uint8_t>* content);

}  // namespace polhode::platform
